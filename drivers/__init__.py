"""What touches hardware: cameras, the servo bus, and the simulated bench that stands in for all of it."""
