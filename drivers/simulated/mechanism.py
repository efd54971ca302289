"""From servo angles to the robot's shape, and from the robot's pull back to the servos."""

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.robot import RobotState, SimulatedRobot
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.settings import DriveSettings

M_PER_MM = 1e-3


class Mechanism:
    """Servos, drive and robot as one. Before the first step the robot stands straight and the stage is at zero."""

    def __init__(self, robot: SimulatedRobot, servos: EmulatedServos, drive: DriveSettings) -> None:
        self._robot = robot
        self._servos = servos
        self._drive = drive
        self._load_Nm: NDArray[np.float64] = np.zeros(robot.servos + 1)

    @property
    def state(self) -> RobotState:
        """The robot after the last step."""
        return self._robot.state

    def step(self, dt_s: float) -> RobotState:
        """Let the servos turn against the robot's last pull, then the robot follow."""
        angle_rad = self._servos.step(dt_s, self._load_Nm)
        displacement_mm = angle_rad[:-1] * self._drive.pulley_mm_per_rad
        state = self._robot.step(displacement_mm, float(angle_rad[-1]) * self._drive.stage_mm_per_rad, dt_s)
        self._load_Nm[:-1] = state.servo_load_N * self._drive.pulley_mm_per_rad * M_PER_MM
        return state
