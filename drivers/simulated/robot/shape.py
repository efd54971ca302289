"""The shape of the robot as others see it: points and directions along the centreline, in the robot frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.backbone import Backbone
from drivers.simulated.robot.equilibrium import Pose
from drivers.simulated.robot.subsegment import move_along

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """The centreline at evenly spaced arc lengths from base to tip."""

    centreline_mm: Array
    """(N, 3) in the robot frame."""
    tangents: Array
    """(N, 3) unit vectors towards the tip."""


class Sampling:
    """Where along the backbone the centreline is sampled."""

    def __init__(self, backbone: Backbone, count: int) -> None:
        """`count` points, evenly spaced from base to tip."""
        ends_mm = np.cumsum(backbone.piece_length_mm)
        arc_mm = np.linspace(0.0, ends_mm[-1], count)
        self._piece = np.minimum(np.searchsorted(ends_mm, arc_mm), len(ends_mm) - 1)
        self._into_piece_mm = arc_mm - (ends_mm - backbone.piece_length_mm)[self._piece]

    def shape(self, pose: Pose, insertion_mm: float) -> Shape:
        """The shape of a robot whose base the stage has moved to z = `insertion_mm`."""
        strain = pose.strain.reshape(-1, 3)[self._piece]
        moved = pose.frames[self._piece] @ move_along(strain, self._into_piece_mm)
        centreline_mm = pose.points_mm[self._piece] + moved[:, :, 0]
        centreline_mm[:, 2] += insertion_mm
        return Shape(centreline_mm, moved[:, :, 1])
