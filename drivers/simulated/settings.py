"""Settings of the simulated bench: its robot, the drive that moves it, its servos and its cameras."""

from typing import Annotated

import msgspec

from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from drivers.simulated.robot.settings import SimulatedRobotSettings
from drivers.simulated.servos.settings import EmulatedServosSettings

MmPerRad = Annotated[float, msgspec.Meta(gt=0, le=1000)]
EitherWayMmPerRad = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]


class DriveSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the servos turn: pulleys for the tendon pairs, and the stage's screw. Positive turns pull and insert, unless a
    pulley is wound the other way.
    """

    pulley_mm_per_rad: MmPerRad = 5.0
    each_pulley_mm_per_rad: tuple[EitherWayMmPerRad, ...] = ()
    """Of every tendon's or pair's pulley, where they are not all alike; negative for one that is wound the other way."""
    stage_mm_per_rad: MmPerRad = 2.0


class SimulationSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The simulated bench.

    `servos.ids` are the tendons' or pairs' in the robot's order, and last the stage's, if the robot stands on one.
    """

    servos: EmulatedServosSettings
    robot: SimulatedRobotSettings = SimulatedRobotSettings()
    drive: DriveSettings = DriveSettings()
    cameras: SimulatedCamerasSettings = SimulatedCamerasSettings()
    rig: str = ""
    """Calibration file that says where the simulated cameras really are; without it the bench's own calibration is right."""
    step_rate_hz: Annotated[float, msgspec.Meta(ge=50, le=500)] = 80.0
    """How often robot and servos move on."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 1
    """Of everything that is drawn by chance: noise, and the cameras' phases and jitter."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        tendons = sum(len(section.tendon_angles_deg) for section in self.robot.sections)
        pulling = tendons // self.robot.tendons_per_servo
        if len(self.servos.ids) not in (pulling, pulling + 1):
            what = "tendon pairs" if self.robot.tendons_per_servo == 2 else "tendons"
            raise ValueError(
                f"servos.ids {list(self.servos.ids)}: the robot has {pulling} {what}, so {pulling} ids are "
                "needed, and the stage's if there is one"
            )
        if len(self.drive.each_pulley_mm_per_rad) not in (0, pulling):
            raise ValueError(
                f"drive.each_pulley_mm_per_rad {list(self.drive.each_pulley_mm_per_rad)}: needed is one for each of the "
                f"{pulling} pulleys, or none"
            )
        if len(self.cameras.body.diameter_mm) != len(self.robot.sections):
            raise ValueError(
                f"cameras.body.diameter_mm {list(self.cameras.body.diameter_mm)}: needed is one for each of the "
                f"robot's {len(self.robot.sections)} sections"
            )
