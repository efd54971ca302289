"""Cameras that Linux offers by V4L2."""
