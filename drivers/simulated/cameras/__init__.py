"""The simulated cameras: exact pictures of the simulated robot, as the JPEG bytes that a webcam would hand out."""
