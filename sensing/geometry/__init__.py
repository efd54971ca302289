"""Cameras, rays and lines in space."""
