"""The true centreline at any moment of a recording, and the points on it. Pure."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from messaging.shape import Truth
from nodal.errors import ReportError

Array = NDArray[np.float64]
Times = NDArray[np.int64]

LARGEST_GAP_NS = 200_000_000
"""Truths further apart than this say nothing about what was between them."""


class TrueShapes:
    """True centrelines in order of time, linearly interpolated in between."""

    def __init__(self, truths: Sequence[Truth]) -> None:
        """All with the same number of points; raises ReportError when there are fewer than two."""
        if len(truths) < 2:
            raise ReportError(f"the recording holds {len(truths)} true shapes; a report needs at least 2")
        ordered = sorted(truths, key=lambda truth: truth.capture_time_ns)
        self._time_ns = np.array([truth.capture_time_ns for truth in ordered])
        self._points_mm = np.array([truth.centreline_mm for truth in ordered])
        self._arc_mm = ordered[0].arc_mm

    def covers(self, time_ns: Times) -> NDArray[np.bool_]:
        """(N,) whether there are truths close enough on both sides of these Unix times (N,) in ns."""
        after, before = self._around(time_ns)
        inside = (time_ns >= self._time_ns[0]) & (time_ns <= self._time_ns[-1])
        return np.asarray(inside & (self._time_ns[after] - self._time_ns[before] <= LARGEST_GAP_NS))

    def centrelines_mm(self, time_ns: Times) -> Array:
        """(N, P, 3) in the robot frame at these Unix times (N,) in ns."""
        after, before = self._around(time_ns)
        span = self._time_ns[after] - self._time_ns[before]
        share = np.clip((time_ns - self._time_ns[before]) / span, 0, 1)[:, None, None]
        return np.asarray((1 - share) * self._points_mm[before] + share * self._points_mm[after])

    def points_mm(self, time_ns: Times, arc_mm: Array) -> Array:
        """(N, M, 3): the points at arc lengths (M,) from the base."""
        lines = self.centrelines_mm(time_ns)
        after = np.clip(np.searchsorted(self._arc_mm, arc_mm), 1, len(self._arc_mm) - 1)
        start, end = self._arc_mm[after - 1], self._arc_mm[after]
        share = ((arc_mm - start) / (end - start))[:, None]
        return np.asarray((1 - share) * lines[:, after - 1] + share * lines[:, after])

    def _around(self, time_ns: Times) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        after = np.clip(np.searchsorted(self._time_ns, time_ns), 1, len(self._time_ns) - 1)
        return after, after - 1
