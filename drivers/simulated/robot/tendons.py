"""Tendons: straight between disks, through a hole at a fixed place of every disk, from the base to their section's tip.

Over a piece of rod with constant strain u the distance between the two holes at r = (rx, ry, 0) is exact in closed form:

    distance^2 = length^2 (P |e3 + u x r|^2 + Q uz^2),   P = 2 A,   Q = length^2 D   (A, D: see `subsegment`),

which follows from looking at both holes from the piece's middle, where only the odd part of the motion counts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.backbone import Backbone
from drivers.simulated.robot.settings import SimulatedRobotSettings
from drivers.simulated.robot.subsegment import Pieces

Array = NDArray[np.float64]

_COLLAPSED_MM2 = (
    1e-6  # holes of neighbouring disks never meet entirely, so that directions between them exist
)


@dataclass(frozen=True)
class TendonPath:
    """Distances between holes and their derivatives, for T tendons and K pieces; zero where a tendon does not run."""

    distance_mm: Array
    """(T, K)."""
    slope_mm2: Array
    """(T, K, 3) by strain."""
    per_distance: Array
    """(T, K) 1/mm."""
    stretch: Array
    """(T, K) 1 + ux ry - uy rx: length along the tendon per length of rod, without twist."""


@dataclass(frozen=True)
class TendonRouting:
    """Where every tendon runs."""

    side_mm: Array
    """(T, K, 3) derivative of the stretch by strain: (ry, -rx, 0)."""
    runs: Array
    """(T, K) one where a tendon passes a piece, zero elsewhere."""
    piece_length_mm: Array
    """(K,)."""
    pitch_squared_mm2: Array
    """(T, K)."""

    def path(self, strain: Array, pieces: Pieces) -> TendonPath:
        """Tendon paths at strain (K, 3)."""
        squared_mm2 = self.piece_length_mm**2
        P, Q = 2 * pieces.A, squared_mm2 * pieces.D
        # these times u are half the derivatives of P and Q
        P_slope, Q_slope = 2 * pieces.A_slope * squared_mm2, pieces.D_slope * squared_mm2**2
        twist = strain[:, 2]
        stretch = 1 + np.einsum("tki,ki->tk", self.side_mm, strain)
        arc_squared = stretch**2 + self.pitch_squared_mm2 * twist**2
        distance = np.sqrt(squared_mm2 * (P * arc_squared + Q * twist**2) + _COLLAPSED_MM2)
        per_distance = self.runs / distance
        slope = (P * stretch)[..., None] * self.side_mm
        slope += (P_slope * arc_squared + Q_slope * twist**2)[..., None] * strain
        slope[..., 2] += (P * self.pitch_squared_mm2 + Q) * twist
        slope *= (per_distance * squared_mm2)[..., None]
        return TendonPath(self.runs * distance, slope, per_distance, stretch)

    def geometric_stiffness(self, path: TendonPath, pieces: Pieces, tension_N: Array) -> Array:
        """Blocks (K, 3, 3) of the second derivative of sum(tension * distance) at fixed tension (T, K).

        Of the chord's own shortening only the leading term is kept: enough for Newton steps.
        """
        squared_mm2 = self.piece_length_mm**2
        P, Q, P_slope = 2 * pieces.A, squared_mm2 * pieces.D, 2 * pieces.A_slope * squared_mm2
        per_distance = tension_N * path.per_distance
        weight = per_distance * squared_mm2
        side = self.side_mm.transpose(1, 2, 0)
        slope = path.slope_mm2.transpose(1, 2, 0)
        blocks = (side * (P * weight).T[:, None]) @ side.transpose(0, 2, 1)
        twisting = blocks[:, 0, 0] + blocks[:, 1, 1] + Q * weight.sum(axis=0)
        blocks -= (slope * per_distance.T[:, None]) @ slope.transpose(0, 2, 1)
        blocks += (P_slope * (weight * path.stretch**2).sum(axis=0))[:, None, None] * np.eye(3)
        blocks[:, 2, 2] += twisting
        return blocks


def route_tendons(settings: SimulatedRobotSettings, backbone: Backbone) -> TendonRouting:
    """Tendons of all sections, section by section in the order of their settings."""
    sides, runs = [], []
    for index, section in enumerate(settings.sections):
        own = backbone.piece_section == index
        crossed = backbone.piece_section < index
        pitch_mm = np.where(
            own, section.pitch_radius_mm, settings.coupling * section.pitch_radius_mm * crossed
        )
        for angle in np.radians(section.tendon_angles_deg):
            sides.append(pitch_mm[:, None] * [np.sin(angle), -np.cos(angle), 0.0])
            runs.append((own | crossed).astype(np.float64))
    side_mm = np.array(sides)
    return TendonRouting(side_mm, np.array(runs), backbone.piece_length_mm, (side_mm**2).sum(axis=2))
