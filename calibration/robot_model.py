"""What identification has to know of a robot: its nominal model, in numbers, and the poses in which it was seen.

The room of calibration knows no controller: whoever calls it hands over the controller's own model, so that what is
identified means the same to the law that uses it.
"""

import dataclasses
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class RobotModel(Protocol):
    """S sections that bend by `bend_of_coordinates` times `coordinates_of_command` times a command (A,), D of whose axes
    are tendons or pairs; the stage, if there is one, is the last.
    """

    bend_of_coordinates: Array
    """(2 S, 2 S) rad per mm."""
    coordinates_of_command: Array
    """(2 S, A)."""
    tendons: int

    def bent(self, bend_rad: Array, arc_mm: Array) -> Array:
        """(n, k, 3) the points at `arc_mm` (k,) of a robot on its base whose sections bend by (n, 2 S)."""
        ...

    def felt(self, position_mm: Array, lost_motion_mm: Array, engaged: Array) -> Array:
        """(n, A) what the robot feels of axes that go through `position_mm` (n, A) in turn, each monotonously, with a lost
        motion of (A,) in which they stand at `engaged` (A,), -1 to 1, at first.
        """
        ...


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Poses:
    """n places at which the robot stood still and was seen, in the order in which it came through them since it was homed."""

    position_mm: Array
    """(n, A) as the servos reported them."""
    node_mm: Array
    """(n, k, 3) in the robot frame."""
    sigma_mm: Array
    """(n, k) of a coordinate of each nodal point: what cameras and their noise leave open."""
    arc_mm: Array
    """(k,)."""

    def __len__(self) -> int:
        return len(self.position_mm)

    def first(self, number: int) -> "Poses":
        """The first so many of them."""
        return dataclasses.replace(
            self,
            position_mm=self.position_mm[:number],
            node_mm=self.node_mm[:number],
            sigma_mm=self.sigma_mm[:number],
        )
