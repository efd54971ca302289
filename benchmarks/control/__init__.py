"""The control laws side by side, in virtual time, on benches drawn by chance: `python -m benchmarks.control`."""
