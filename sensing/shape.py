"""A resolved shape, whichever method found it: the centreline, how far it is to be trusted, and what led to it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from messaging.checked import FloatArray
from messaging.shape import Flag, NodalPoints
from sensing.errors import NodalPointError
from sensing.pictures.segmentation import Mask
from sensing.refined.track import Track

BEYOND_TIP_MM = 1.0
"""A nodal point may lie this far beyond the measured tip, or a fiftieth of the length: there the line goes straight on."""


class Centreline(Protocol):
    """A line in space from base to tip that knows how exact it is."""

    @property
    def points_mm(self) -> FloatArray:
        """Points (n, 3) along the line."""

    @property
    def arc_mm(self) -> FloatArray:
        """Their distances (n,) from the base along the line (METHOD step 9)."""

    def at(self, arc_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (k, 3) and covariances (k, 3, 3) at distances (k,); beyond the tip the line goes straight on."""


@dataclass(frozen=True)
class Silhouette:
    """One camera's stages: mask (h, w) at detection size, skeleton (n, 2) in full-size px, and the half width there."""

    mask: Mask
    skeleton: FloatArray
    half_width_px: float


@dataclass(frozen=True)
class Stages:
    """The way to a shape that was found without a prior: silhouettes by camera, triangulated points (n, 3), their gaps (n,)."""

    silhouettes: Mapping[str, Silhouette]
    points_mm: FloatArray
    gaps_mm: FloatArray


@dataclass(frozen=True)
class Evidence:
    """How the cameras agree with a centreline of n points, and how well they can tell.

    `residual_px` and `visible_mm` are by camera: the RMS distance between the reprojected centreline and the measured
    midline, and the length along which it was measured. `ray_gap_mm` is the mean gap between paired rays, `ray_bias_mm`
    by how much one camera's picture seems to lie elsewhere than its calibration says. `epipolar_angle_rad` (n,) is the
    angle to the epipolar direction of the two cameras that see the point best.
    """

    residual_px: Mapping[str, float]
    visible_mm: Mapping[str, float]
    ray_gap_mm: float
    ray_bias_mm: float
    epipolar_angle_rad: FloatArray
    flags: tuple[Flag, ...]


@dataclass(frozen=True)
class Shape:
    """`stages` are those of the search that began it, or None when it followed from a prior.

    `track` is what the next estimate may start from, where the method has use for it.
    """

    centreline: Centreline
    insertion_mm: float
    evidence: Evidence
    stages: Stages | None
    track: Track | None
    stage_s: Mapping[str, float]

    @property
    def flags(self) -> tuple[Flag, ...]:
        """What speaks against the shape."""
        return self.evidence.flags

    @property
    def length_mm(self) -> float:
        """Measured length of the centreline."""
        return float(self.centreline.arc_mm[-1])

    @property
    def residual_px(self) -> float:
        """RMS over the cameras of how far the reprojected centreline is from the measured midline."""
        return float(np.sqrt(np.mean(np.square(list(self.evidence.residual_px.values())))))

    def nodes(self, arc_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (n, 3) and covariances (n, 3, 3) of the points at these distances from the base (METHOD step 9).

        Raises NodalPointError for a point beyond the robot.
        """
        length = self.length_mm
        if (arc_mm > length + max(BEYOND_TIP_MM, length / 50)).any():
            raise NodalPointError(
                f"nodal point at {arc_mm.max():g} mm is beyond the robot, whose centreline is {length:.2f} mm long"
            )
        return self.centreline.at(arc_mm)


def covered_nodes(points: NodalPoints, length_mm: float) -> NodalPoints:
    """The same nodal points; raises NodalPointError for one beyond a robot of this length."""
    if points.arc_mm[-1] > length_mm:
        raise NodalPointError(
            f"nodal point {points.names[-1]} at {points.arc_mm[-1]:g} mm is beyond the robot; "
            f"allowed are 0 to {length_mm:g} mm"
        )
    return points
