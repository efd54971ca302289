"""What stands on a virtual bench. Lengths in mm, times in s."""

from typing import Annotated

import msgspec

from drivers.simulated.robot.settings import SimulatedRobotSettings
from drivers.simulated.servos.settings import MotorSettings

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]


class ShapeSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the shape is seen: nothing but when it arrives and how wrong it is."""

    rate_hz: Annotated[float, msgspec.Meta(ge=1, le=1000)] = 30.0
    delay_s: NotNegative = 0.035
    """From capture to arrival, on average. A shape cannot arrive before the robot's next step, so 0 means up to 15 ms."""
    jitter_s: NotNegative = 0.01
    """Arrivals spread evenly over so much to either side."""
    dropped: Share = 0.0
    """Share of shapes that never arrive."""
    noise_mm: NotNegative = 0.03
    """Standard deviation of each coordinate of each nodal point."""
    node_names: tuple[str, ...] = ("proximal", "middle", "distal", "tip")
    node_arc_mm: tuple[float, ...] = (20.0, 40.0, 60.0, 80.0)


class ServoSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The servos as the controller's drive sets them up, and by how much their pulleys differ from what it believes."""

    tendon_mm_per_rad: Positive = 5.0
    stage_mm_per_rad: Positive = 2.0
    gain: tuple[Positive, ...] = ()
    """True motion of each axis per motion that is asked for, tendons (or pairs) first; empty means 1 for all."""
    maximum_current_ma: Positive = 1000.0
    profile_velocity_rad_s: Positive = 4.0
    profile_acceleration_rad_s2: Positive = 100.0
    watchdog_ms: Annotated[int, msgspec.Meta(ge=20, le=2540)] = 200
    unanswered_s: NotNegative = 0.06
    """How long the drive waits, retries included, before it gives a silent servo up; the loop stands still meanwhile."""
    motor: MotorSettings = MotorSettings()


class VirtualBenchSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One bench. The controller that runs on it is told none of this."""

    robot: SimulatedRobotSettings = SimulatedRobotSettings(centreline_points=41)
    stage: bool = True
    """Whether the robot stands on a linear stage; then its servo is the last."""
    servos: ServoSettings = ServoSettings()
    shape: ShapeSettings = ShapeSettings()
    robot_step_s: Annotated[float, msgspec.Meta(gt=0, le=0.025)] = 0.015
    """How often the robot moves on, in whole cycles of the controller; between its steps positions are interpolated."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 1
