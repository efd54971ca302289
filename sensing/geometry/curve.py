"""The centreline as a cubic B-spline in space, and the points along it.

Positions are linear in the control points, so fitting needs no derivatives by hand; the parameter runs from 0 at the
base to 1 at the tip, and a fit that asks for constant speed makes it the arc length over the length.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from messaging.checked import FloatArray
from sensing.geometry.vectors import lengths

DEGREE = 3
CONTROL_POINTS = 14
SAMPLES = 81
"""Points along the curve at which it is measured and reported."""


@lru_cache(maxsize=16)
def _spline(order: int) -> BSpline:
    knots = np.concatenate(
        [np.zeros(DEGREE), np.linspace(0.0, 1.0, CONTROL_POINTS - DEGREE + 1), np.ones(DEGREE)]
    )
    spline = BSpline(knots, np.eye(CONTROL_POINTS), DEGREE)
    return spline.derivative(order) if order else spline


def basis(parameter: FloatArray, order: int = 0) -> FloatArray:
    """The matrix (k, CONTROL_POINTS) that takes control points to positions (or derivatives) at parameters (k,)."""
    return np.asarray(_spline(order)(parameter))


PARAMETER: FloatArray = np.linspace(0.0, 1.0, SAMPLES)
POSITION = basis(PARAMETER)
VELOCITY = basis(PARAMETER, 1)
FINE_PARAMETER: FloatArray = np.linspace(0.0, 1.0, 8 * SAMPLES)
FINE_POSITION = basis(FINE_PARAMETER)
"""Fine enough for arc length: chords are a thousandth of the length."""
JUMPS: FloatArray = np.diff(basis(np.linspace(0, 1, 4 * CONTROL_POINTS), 2), axis=0)
"""Takes control points to the changes of the second derivative along the curve."""


def fit_points(points_mm: FloatArray, parameter: FloatArray) -> FloatArray:
    """Control points (CONTROL_POINTS, 3) of the smooth curve nearest to points (n, 3) at parameters (n,)."""
    rows = np.vstack([basis(parameter) * np.sqrt(CONTROL_POINTS / max(len(parameter), 1)), 2e-3 * JUMPS])
    right = np.vstack(
        [points_mm * np.sqrt(CONTROL_POINTS / max(len(parameter), 1)), np.zeros((len(JUMPS), 3))]
    )
    return np.asarray(np.linalg.lstsq(rows, right, rcond=None)[0])


def arc_lengths(points_mm: FloatArray) -> FloatArray:
    """Distance (n,) from the first of points (n, 3) along the line through them (METHOD step 9)."""
    steps = lengths(points_mm[1:] - points_mm[:-1])[:, 0]
    return np.concatenate([[0.0], np.cumsum(steps)])


def resample(points_mm: FloatArray, count: int) -> FloatArray:
    """The line through points (n, d), at `count` equally spaced places along it."""
    arc = arc_lengths(points_mm)
    places = np.linspace(0.0, arc[-1], count)
    return np.column_stack([np.interp(places, arc, column) for column in points_mm.T])


Mask = NDArray[np.uint8]
