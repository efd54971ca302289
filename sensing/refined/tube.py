"""The robot as a tube in space, and where cameras see its edges and its end.

A tube's silhouette is not symmetric about its axis' image: its contour lies nearer to the camera than the axis by
r^2/D, so edges are predicted from there and the perspective bias of the midline cancels. A round tip is a half sphere
whose centre lies one radius before the centreline's end; a flat one is the face at the end, an ellipse in the picture,
as deep as the face is turned towards the camera.
"""

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from messaging.checked import FloatArray
from sensing.geometry import curve
from sensing.geometry.vectors import cross, inner, lengths

END_LINES: FloatArray = np.array([-0.75, -0.4, 0.0, 0.4, 0.75])
"""Where across the end, in radii, its outline is looked for."""
INSIDE = 1.2
"""How far before the centreline's end, in radii, the search for the silhouette's end begins."""


class Tip(StrEnum):
    """How the tube ends: in a half sphere whose apex is the centreline's end, or in a face."""

    ROUND = "round"
    FLAT = "flat"


@dataclass(frozen=True)
class Curve:
    """A centreline: control points (n, 3) in mm, its length, and the tube's radius along it at `curve.PARAMETER`."""

    control_mm: FloatArray
    length_mm: float
    radius_mm: FloatArray

    @cached_property
    def points_mm(self) -> FloatArray:
        """Centreline (SAMPLES, 3)."""
        return curve.POSITION @ self.control_mm

    @cached_property
    def velocity_mm(self) -> FloatArray:
        """Derivative (SAMPLES, 3) by the parameter: tangents as long as the robot."""
        return curve.VELOCITY @ self.control_mm


@dataclass(frozen=True)
class Sides:
    """Where v cameras see the tube's two edges: points (v, n, 3) of one, the other and the middle between, robot frame.

    `foreshortening` (v, n) is the sine between tube and sight: 1 from the side, 0 end on, where there are no edges.
    """

    middle: FloatArray
    one: FloatArray
    other: FloatArray
    foreshortening: FloatArray


@dataclass(frozen=True)
class End:
    """Where v cameras see the tube end: its outline (v, k, 3) along END_LINES, and where to begin (v, k, 3), robot frame.

    The outline moves with the curve's point that `basis` (CONTROL_POINTS,) takes the control points to.
    """

    outline: FloatArray
    inside: FloatArray
    foreshortening: FloatArray
    basis: FloatArray


def sides(centres_mm: FloatArray, fitted: Curve) -> Sides:
    """The contour generators of the tube as cameras at `centres_mm` (v, 3) see it."""
    points, radius = fitted.points_mm, fitted.radius_mm
    tangents = fitted.velocity_mm / lengths(fitted.velocity_mm)
    sight = points - centres_mm[:, None]
    across = sight - inner(sight, tangents) * tangents
    distance = lengths(across)
    towards = across / np.maximum(distance, 2 * radius[:, None])
    sine = radius[:, None] / np.maximum(distance, 2 * radius[:, None])
    middle = points - radius[:, None] * sine * towards
    side = radius[:, None] * np.sqrt(1 - sine**2) * cross(tangents, towards)
    return Sides(middle, middle + side, middle - side, (distance / lengths(sight))[..., 0])


def end(centres_mm: FloatArray, fitted: Curve, tip: Tip) -> End:
    """The tube's end as cameras at `centres_mm` (v, 3) see it."""
    radius = float(fitted.radius_mm[-1])
    at = 1.0 - min(radius / fitted.length_mm, 0.5) if tip is Tip.ROUND else 1.0
    basis, slope = (curve.basis(np.array([at]), order)[0] for order in (0, 1))
    place, tangent = basis @ fitted.control_mm, slope @ fitted.control_mm
    tangent = tangent / np.sqrt(tangent @ tangent)
    sight = place - centres_mm
    sight = sight / lengths(sight)
    onwards = tangent - inner(sight, tangent) * sight
    foreshortening = lengths(onwards)
    onwards = onwards / np.maximum(foreshortening, 1e-9)
    sideways = radius * cross(sight, onwards)
    depth = radius * np.sqrt(1 - END_LINES**2)[:, None]
    if tip is Tip.FLAT:
        depth = depth * np.abs(inner(sight, tangent))[:, None]
    across = place + END_LINES[:, None] * sideways[:, None]
    before = INSIDE * radius - (1.0 - at) * fitted.length_mm
    return End(across + depth * onwards[:, None], across - before * tangent, foreshortening[..., 0], basis)
