"""Motions through configurations: what brings nodal points to a place, and a way there that keeps clear. NumPy alone."""
