"""The shape of the robot as others see it: points and directions along the centreline, in the robot frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.backbone import Backbone
from drivers.simulated.robot.equilibrium import Configuration
from drivers.simulated.robot.subsegment import move_along

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """The centreline at evenly spaced arc lengths from base to tip."""

    centreline_mm: Array
    """(N, 3) in the robot frame."""
    tangents: Array
    """(N, 3) unit vectors towards the tip."""


def sample_shape(backbone: Backbone, configuration: Configuration, insertion_mm: float, count: int) -> Shape:
    """`count` points of the robot, whose base the stage has moved to z = `insertion_mm`."""
    ends_mm = np.cumsum(backbone.piece_length_mm)
    arc_mm = np.linspace(0.0, ends_mm[-1], count)
    piece = np.minimum(np.searchsorted(ends_mm, arc_mm), len(ends_mm) - 1)
    into_piece_mm = arc_mm - (ends_mm - backbone.piece_length_mm)[piece]
    rotation, translation = move_along(configuration.strain.reshape(-1, 3)[piece], into_piece_mm)
    frames = configuration.frames[piece]
    points = configuration.points_mm[piece] + (frames @ translation[:, :, None])[:, :, 0]
    return Shape(points + [0.0, 0.0, insertion_mm], (frames @ rotation[:, :, 2:])[:, :, 0])
