"""A bench in virtual time: the controller's loop, servos, the simulated robot and a camera-rate shape; no images, no clock."""
