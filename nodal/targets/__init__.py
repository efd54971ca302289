"""Targets as an operator asks for them: places, lines, splines, circles, a path from a file. Positions in mm, robot frame."""

from nodal.targets.curves import circle, line, on_circle, spline
from nodal.targets.held import points
from nodal.targets.path_file import path

__all__ = ["circle", "line", "on_circle", "path", "points", "spline"]
