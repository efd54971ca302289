"""Servos, pulleys and robot as one, moved on in virtual time; and what may happen to them in the middle of a run."""

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.robot import RobotState, SimulatedRobot
from drivers.simulated.servos.servo import Servo
from drivers.simulated.servos.settings import EmulatedServosSettings
from nodal.virtual.errors import VirtualBenchError
from nodal.virtual.settings import VirtualBenchSettings

Array = NDArray[np.float64]

_M_PER_MM = 1e-3


class Plant:
    """Axes are numbered tendons (or pairs) first, and last the stage if there is one; all are at zero at first."""

    def __init__(self, settings: VirtualBenchSettings) -> None:
        """Raises RobotBuildError, and VirtualBenchError when there is not one gain for each axis."""
        self.robot = SimulatedRobot(settings.robot)
        self.tendon_axes = self.robot.servos
        self.axes = self.tendon_axes + settings.stage
        bus = EmulatedServosSettings(
            link="virtual", ids=tuple(range(1, self.axes + 1)), motor=settings.servos.motor
        )
        self.servos = [Servo(bus, servo_id) for servo_id in bus.ids]
        tendon_mm, stage_mm = settings.servos.tendon_mm_per_rad, settings.servos.stage_mm_per_rad
        self.nominal_mm_per_rad = np.array([tendon_mm] * self.tendon_axes + [stage_mm] * settings.stage)
        gain = np.array(settings.servos.gain or (1.0,) * self.axes)
        if gain.shape != (self.axes,):
            raise VirtualBenchError(f"gain {gain.tolist()}: one is needed for each of the {self.axes} axes")
        self.mm_per_rad = self.nominal_mm_per_rad * gain
        self.jammed: set[int] = set()
        """Axes that do not turn, whatever drives them."""
        self._load_Nm = np.zeros(self.axes)

    @property
    def state(self) -> RobotState:
        """The robot after its last step."""
        return self.robot.state

    def turn(self, dt_s: float, now_s: float) -> None:
        """Let the servos turn for `dt_s` against the robot's last pull."""
        for axis, servo in enumerate(self.servos):
            stuck_rad = servo.motor.position_rad
            servo.step(dt_s, float(self._load_Nm[axis]), now_s)
            if axis in self.jammed:
                servo.motor.position_rad, servo.motor.velocity_rad_s = stuck_rad, 0.0

    def follow(self, dt_s: float) -> RobotState:
        """Let the robot follow what the servos have turned in the last `dt_s`."""
        moved_mm = self.mm_per_rad * [servo.motor.position_rad for servo in self.servos]
        tendons = slice(self.tendon_axes)
        state = self.robot.step(moved_mm[tendons], float(moved_mm[self.tendon_axes :].sum()), dt_s)
        self._load_Nm[tendons] = state.servo_load_N * self.mm_per_rad[tendons] * _M_PER_MM
        return state
