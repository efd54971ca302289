"""What stands before the cameras. On a real bench a person sees to it; on a simulated one the simulation does, when asked."""

import dataclasses
from enum import StrEnum
from typing import ClassVar

from google.protobuf.message import Message as ProtobufMessage

from messaging.generated import nodal_pb2
from messaging.message import Message


class Scene(StrEnum):
    """What calibration may ask for."""

    ROBOT = "robot"
    """The robot in its holder: the bench as it runs."""
    EMPTY = "empty"
    """The holder without the robot."""
    BOARD = "board"
    """A board, held still at one place after another, all over the pictures and tilted every way."""
    BOARD_AT_BASE = "board_at_base"
    """The board in its fixture at the base, with the stage at zero."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class SceneRequest(Message):
    """Have this scene set up."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.SceneRequest

    scene: Scene
