"""Where along the centreline each of many rays passes closest."""

from dataclasses import dataclass

import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Index
from drivers.simulated.cameras.curve import Curve

_LARGEST_STEP_MM = np.float32(3.0)
_ROUNDS_WHEN_UNCERTAIN = 2
_TINY = np.float32(1e-6)


@dataclass(frozen=True)
class Passage:
    """How m rays (x, y, 1) pass the curve, each at its closest point."""

    sample: Index
    """(m,) index of a sample of the curve beside that point."""
    distance_mm: Flat
    """(m,) between the ray and the centreline."""
    sideways_mm: Flat
    """(m,) share of the distance across the tube; the rest of it lies along the tube, at the tip."""
    point_mm: Flat
    """(3, m) on the centreline."""
    ray: tuple[Flat, Flat]
    """x and y (m,) of the ray."""
    depth_mm: Flat
    """(m,) of the ray's point, along the view."""
    obliquity: Flat
    """(m,) sine of the angle between the ray and the tube, times the length of (x, y, 1)."""
    aside: Flat
    """(3, m) unit vectors across the ray and the tube, the way that `sideways_mm` counts."""

    @property
    def outwards(self) -> Flat:
        """(3, m) unit vectors from the centreline to the rays."""
        ray = np.stack([self.depth_mm * self.ray[0], self.depth_mm * self.ray[1], self.depth_mm])
        away: Flat = (ray - self.point_mm) / np.maximum(self.distance_mm, _TINY)
        return away


def pass_by(curve: Curve, end_mm: float, x: Flat, y: Flat, start_mm: Flat, uncertain: Index) -> Passage:
    """Find the passages of rays (m,), starting from distances (m,) from the curve's first sample.

    Passages beyond `end_mm`, also from the first sample, are held there. Newton's method on the squared distance: one
    round is exact to a micrometre from within a few tenths of a millimetre; `uncertain` rays are given more.
    """
    course = _Course(_rows(curve.points_mm), _rows(curve.tangents), curve.spacing_mm, end_mm)
    along = np.clip(start_mm, 0, np.float32(end_mm))
    for _ in range(_ROUNDS_WHEN_UNCERTAIN if uncertain.size else 0):
        near = course.approach(x[uncertain], y[uncertain], along[uncertain])
        along[uncertain] = near.along_mm
    near = course.approach(x, y, along)
    point, moment, turn = near.point_mm, near.moment, near.turn
    ray2 = x * x + y * y + 1
    obliquity = np.sqrt(np.maximum(dot(turn, turn), _TINY))
    return Passage(
        sample=near.sample,
        distance_mm=np.sqrt(dot(moment, moment) / ray2),
        sideways_mm=-dot(point, turn) / obliquity,
        point_mm=point,
        ray=(x, y),
        depth_mm=(point[0] * x + point[1] * y + point[2]) / ray2,
        obliquity=obliquity,
        aside=turn / obliquity,
    )


@dataclass(frozen=True)
class _Approach:
    """Rays and the points of the curve that one round found for them."""

    sample: Index
    along_mm: Flat
    point_mm: Flat
    moment: Flat
    """(3, m) of the ray about the point: its length over the ray's is the distance, without the cancellation of a
    difference of large squares."""
    turn: Flat
    """(3, m) the tangent cross the ray."""


@dataclass(frozen=True)
class _Course:
    """The curve in single precision: points (3, n), tangents (3, n), and how far it goes."""

    points: Flat
    tangents: Flat
    spacing_mm: float
    end_mm: float

    def approach(self, x: Flat, y: Flat, along: Flat) -> _Approach:
        """One round, from the line through the sample nearest to each place `along` (m,) the curve."""
        spacing = np.float32(self.spacing_mm)
        sample = np.rint(along / spacing).astype(np.intp)
        tangent = self.tangents.take(sample, axis=1, mode="clip")
        point = self.points.take(sample, axis=1, mode="clip")
        point += (along - sample.astype(np.float32) * spacing) * tangent
        moment, turn = _cross_ray(point, x, y), _cross_ray(tangent, x, y)
        step = dot(moment, turn) / -np.maximum(dot(turn, turn), _TINY)
        moved = along + np.clip(step, -_LARGEST_STEP_MM, _LARGEST_STEP_MM)
        moved = np.clip(moved, 0, np.float32(self.end_mm))
        step = moved - along
        moment += step * turn
        point += step * tangent
        return _Approach(sample, moved, point, moment, turn)


def gather(table: Array, rows: Index) -> Flat:
    """(k, m): rows (m,) of a table (n, k)."""
    return _rows(table).take(rows, axis=1, mode="clip")


def _rows(table: Array) -> Flat:
    return np.ascontiguousarray(table.T, dtype=np.float32)


def dot(a: Flat, b: Flat) -> Flat:
    """(m,) products of columns of (3, m) and (3, m)."""
    product: Flat = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def _cross_ray(vector: Flat, x: Flat, y: Flat) -> Flat:
    """(3, m) vectors cross (x, y, 1)."""
    crossed = np.empty_like(vector)
    np.subtract(vector[1], vector[2] * y, out=crossed[0])
    np.subtract(vector[2] * x, vector[0], out=crossed[1])
    np.subtract(vector[0] * y, vector[1] * x, out=crossed[2])
    return crossed
