"""Sensing: a set of camera frames in, the robot's 3-D centreline and its nodal points out."""
