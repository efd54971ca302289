"""The simulated bench: a robot, its servos behind a serial device, and its cameras."""
