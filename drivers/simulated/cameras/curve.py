"""The robot's centreline as the tube needs it: finely sampled in the camera frame, with its motion while the shutter is open."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from drivers.simulated.cameras.arrays import Array
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.vectors import lengths, units

_FINER = (
    4  # a chord of a quarter millimetre strays by less than a micrometre from any curve the robot can take
)


@dataclass(frozen=True)
class Curve:
    """`count` samples, evenly spaced in arc length. The first `below` of them lead straight down into the holder."""

    spacing_mm: float
    arc_mm: Array
    """(n,) from the base; negative below it."""
    points_mm: Array
    """(n, 3) in the camera frame, at mid-exposure."""
    tangents: Array
    """(n, 3) unit vectors towards the tip."""
    motion_mm: Array
    """(n, 3) from the opening of the shutter to its closing."""

    @property
    def length_mm(self) -> float:
        """From the base to the tip."""
        return float(self.arc_mm[-1])

    def at(self, arc_mm: Array) -> tuple[Array, Array]:
        """Points (m, 3) and tangents (m, 3) at distances (m,) from the base."""
        nearest = np.rint((arc_mm - self.arc_mm[0]) / self.spacing_mm).astype(int)
        rest = (arc_mm - self.arc_mm[nearest])[:, None]
        return self.points_mm[nearest] + rest * self.tangents[nearest], self.tangents[nearest]


def see_curve(opened_mm: Array, closed_mm: Array, below_mm: float, projection: Projection) -> Curve:
    """The curve between two centrelines (N, 3) in the robot frame, when the shutter opened and when it closed."""
    length_mm = float(lengths(np.diff(closed_mm, axis=0)).sum())
    values, slopes = _spline(len(closed_mm))
    opened, closed = projection.to_camera(values @ opened_mm), projection.to_camera(values @ closed_mm)
    middle = (opened + closed) / 2
    tangents = units(slopes @ (opened_mm + closed_mm) @ projection.rotation.T)
    spacing_mm = length_mm / (len(values) - 1)
    below = int(np.ceil(below_mm / spacing_mm))
    steps = -spacing_mm * np.arange(below, 0, -1.0)
    return Curve(
        spacing_mm=spacing_mm,
        arc_mm=spacing_mm * np.arange(-below, len(values), dtype=np.float64),
        points_mm=np.concatenate([middle[0] + steps[:, None] * tangents[0], middle]),
        tangents=np.concatenate([np.repeat(tangents[:1], below, axis=0), tangents]),
        motion_mm=np.concatenate([np.repeat((closed - opened)[:1], below, axis=0), closed - opened]),
    )


@lru_cache(maxsize=2)
def _spline(count: int) -> tuple[Array, Array]:
    """Matrices (fine, count) that take points to finer points and to slopes of the cubic spline through them."""
    spline = CubicSpline(np.arange(count), np.eye(count))
    fine = np.arange((count - 1) * _FINER + 1) / _FINER
    return spline(fine), spline(fine, 1)
