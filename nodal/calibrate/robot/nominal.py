"""The controller's own model of the robot, as identification wants it."""

import numpy as np
from numpy.typing import NDArray

from controller.kinematics import Kinematics
from controller.lost_motion import engaged_after, felt_mm

Array = NDArray[np.float64]


class NominalModel:
    """Implements `calibration.robot_model.RobotModel`."""

    def __init__(self, kinematics: Kinematics, engaging_mm: float) -> None:
        """`engaging_mm` of the law that will use what is identified."""
        self._kinematics, self._engaging_mm = kinematics, engaging_mm
        self.bend_of_coordinates: Array = kinematics.bend_of_coordinates
        bends = 2 * len(kinematics.length_mm)
        self.coordinates_of_command: Array = np.array(kinematics.coordinates_of_command[:bends], np.float64)
        self.tendons = kinematics.tendons

    def bent(self, bend_rad: Array, arc_mm: Array) -> Array:
        """See `RobotModel`."""
        return self._kinematics.bent(bend_rad, arc_mm)[0]

    def felt(self, position_mm: Array, lost_motion_mm: Array, engaged: Array) -> Array:
        """See `RobotModel`."""
        felt, before = np.empty_like(position_mm), np.zeros(position_mm.shape[1])
        for row, position in enumerate(position_mm):
            engaged = engaged_after(engaged, position - before, lost_motion_mm, self._engaging_mm)
            felt[row], before = felt_mm(position, engaged, lost_motion_mm), position
        return felt
