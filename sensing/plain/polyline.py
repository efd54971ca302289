"""The centreline as straight pieces between points, with the uncertainty of each (METHOD step 9)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from messaging.checked import FloatArray
from sensing.geometry import curve

END_SLOPE = 0.1
"""By how much, in rad, the line may go on in another direction than its last piece."""


@dataclass(frozen=True)
class Polyline:
    """See `sensing.shape.Centreline`: points (n, 3) in mm from base to tip and their covariances (n, 3, 3)."""

    points_mm: FloatArray
    covariance_mm2: FloatArray

    @cached_property
    def arc_mm(self) -> FloatArray:
        """Distances (n,) from the base along the line."""
        return curve.arc_lengths(self.points_mm)

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit directions (n, 3): in a corner the mean of the pieces on both sides."""
        pieces = np.diff(self.points_mm, axis=0)
        pieces /= np.linalg.norm(pieces, axis=1, keepdims=True)
        mean = np.vstack([pieces[:1], pieces[:-1] + pieces[1:], pieces[-1:]])
        return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12))

    def at(self, arc_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (k, 3) and covariances (k, 3, 3) at distances (k,) from the base, by linear interpolation.

        Beyond the tip the line goes straight on, and the covariance grows.
        """
        positions = np.column_stack([np.interp(arc_mm, self.arc_mm, column) for column in self.points_mm.T])
        flat = self.covariance_mm2.reshape(-1, 9)
        covariance = np.column_stack([np.interp(arc_mm, self.arc_mm, column) for column in flat.T])
        beyond = np.maximum(arc_mm - self.arc_mm[-1], 0.0)
        positions += beyond[:, None] * self.tangents[-1]
        return positions, covariance.reshape(-1, 3, 3) + _onwards(self.tangents[-1], beyond, END_SLOPE)


def _onwards(tangent: FloatArray, reach_mm: FloatArray, slope: float) -> FloatArray:
    """Covariances (k, 3, 3) across a tangent (3,) of going straight on by `reach_mm` (k,)."""
    across = np.eye(3) - np.outer(tangent, tangent)
    return np.asarray((slope * reach_mm[:, None, None]) ** 2 * across)
