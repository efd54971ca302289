"""Mechanics of the simulated tendon-driven continuum robot: displacements in, shape and tensions out."""
