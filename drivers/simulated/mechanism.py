"""From servo angles to the robot's shape, and from the robot's pull back to the servos."""

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.robot import RobotState, SimulatedRobot
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.settings import DriveSettings
from drivers.simulated.stage_place import StagePlace

M_PER_MM = 1e-3


class Mechanism:
    """Servos, drive and robot as one. Before the first step the robot stands straight and the stage, if any, where it was."""

    def __init__(
        self, robot: SimulatedRobot, servos: EmulatedServos, drive: DriveSettings, place: StagePlace
    ) -> None:
        """`place` is asked where the stage stood, and told where it stands."""
        self._robot = robot
        self._place = place if servos.count > robot.servos else None
        if self._place is not None:
            servos.stand_at(robot.servos, self._place.recalled_rad())
        self._servos = servos
        self._stage_mm_per_rad = drive.stage_mm_per_rad
        self._pulley_mm_per_rad = np.array(
            drive.each_pulley_mm_per_rad or robot.servos * (drive.pulley_mm_per_rad,)
        )
        self._load_Nm: NDArray[np.float64] = np.zeros(servos.count)

    @property
    def state(self) -> RobotState:
        """The robot after the last step."""
        return self._robot.state

    def step(self, dt_s: float) -> RobotState:
        """Let the servos turn against the robot's last pull, then the robot follow."""
        angle_rad, pulling = self._servos.step(dt_s, self._load_Nm), self._robot.servos
        displacement_mm = angle_rad[:pulling] * self._pulley_mm_per_rad
        insertion_mm = float(angle_rad[pulling:].sum()) * self._stage_mm_per_rad
        if self._place is not None:
            self._place.keep(float(angle_rad[-1]))
        state = self._robot.step(displacement_mm, insertion_mm, dt_s)
        self._load_Nm[:pulling] = state.servo_load_N * self._pulley_mm_per_rad * M_PER_MM
        return state
