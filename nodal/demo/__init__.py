"""The demo: every process of a bench, started, watched, restarted and stopped, and led through one scenario."""
