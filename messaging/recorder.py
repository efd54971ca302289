"""What an operator says to the recorder."""

import dataclasses
from enum import StrEnum
from typing import ClassVar

from google.protobuf.message import Message as ProtobufMessage

from messaging.generated import nodal_pb2
from messaging.message import Message


class RecorderAction(StrEnum):
    """What may be asked of the recorder."""

    START = "start"
    """Begin a recording."""
    STOP = "stop"
    """Finish the recording."""
    SAVE = "save"
    """Write what the rolling buffer holds, and a little of what follows, into a recording of its own."""
    STATUS = "status"


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class RecorderRequest(Message):
    """One action asked of the recorder. `file` is a path on its host; empty: named by the time, in `recorder.folder`."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.RecorderRequest

    action: RecorderAction
    file: str
