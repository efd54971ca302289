"""What stands in a bench file: the settings of every room, composed. docs/bench-file.md says what each key means."""

from typing import Annotated

import msgspec

from controller.settings import ControllerSettings
from drivers.cameras.settings import CameraSettings
from drivers.dynamixel.settings import ServoSettings
from drivers.simulated.settings import SimulationSettings
from messaging.board import BoardSettings
from messaging.settings import RobotSettings, ZenohSettings
from recordings.settings import RecorderSettings
from sensing.settings import SensingSettings

Name = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]+$")]


class BenchSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What stands in a bench file."""

    name: Name
    robot: RobotSettings
    calibration: str
    cameras: Annotated[dict[Name, CameraSettings], msgspec.Meta(min_length=2)]
    sensing: SensingSettings
    servos: ServoSettings
    controller: ControllerSettings = ControllerSettings()
    recorder: RecorderSettings = RecorderSettings()
    zenoh: ZenohSettings = ZenohSettings()
    board: BoardSettings = BoardSettings()
    simulation: SimulationSettings | None = None
