"""Where points lie with a given confidence: ellipses in a picture, ellipsoids in space, and how to make them seen. Pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nodal.report.confidence import semi_axes
from sensing.geometry.camera import Camera

Array = NDArray[np.float64]

FACTORS = (1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200, 250, 400, 500, 1000)
"""By which 10 mm can be divided in the head."""
AROUND: Array = np.linspace(0.0, 2 * np.pi, 73)
POLES: Array = np.linspace(0.0, np.pi, 25)
CIRCLE: Array = np.column_stack([np.cos(AROUND), np.sin(AROUND)])
SPHERE: Array = np.stack(
    [
        np.outer(np.sin(POLES), np.cos(AROUND)),
        np.outer(np.sin(POLES), np.sin(AROUND)),
        np.outer(np.cos(POLES), np.ones_like(AROUND)),
    ],
    axis=-1,
)


@dataclass(frozen=True, eq=False)
class Region:
    """An ellipse (d = 2) or an ellipsoid (d = 3) around a centre (d,); `semi_axes` (d, d) has one a row, the longest first."""

    centre: Array
    semi_axes: Array

    @classmethod
    def of(cls, centre: Array, covariance: Array, confidence: float) -> "Region":
        """Where a point with this covariance (d, d) lies with this confidence."""
        return cls(centre, semi_axes(covariance, confidence))

    @property
    def reach(self) -> float:
        """The longest semi-axis."""
        return float(np.linalg.norm(self.semi_axes[0]))

    def surface(self, magnified: float = 1.0) -> Array:
        """Points of an ellipse (n, 2), closed, or of an ellipsoid (rows, columns, 3), `magnified` times too large."""
        unit = CIRCLE if len(self.centre) == 2 else SPHERE
        return np.asarray(self.centre + magnified * unit @ self.semi_axes)

    def sections(self, magnified: float = 1.0) -> list[Array]:
        """The three ellipses (n, 3) of an ellipsoid that hold two of its axes each."""
        return [
            np.asarray(self.centre + magnified * CIRCLE @ self.semi_axes[list(two)])
            for two in ((0, 1), (0, 2), (1, 2))
        ]


def ellipse_px(camera: Camera, point_mm: Array, covariance_mm2: Array, confidence: float) -> Region:
    """Where a camera would see a point (3,) with this covariance (3, 3), to first order, in px."""
    pixel, jacobian = camera.project_with_jacobian(point_mm[None])
    return Region.of(pixel[0], jacobian[0] @ covariance_mm2 @ jacobian[0].T, confidence)


def magnification(largest: float, room: float) -> int:
    """The largest of FACTORS by which something of this size still fits into so much room; at least 1."""
    return max(factor for factor in FACTORS if factor == 1 or factor * largest <= room)
