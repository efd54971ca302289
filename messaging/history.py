"""What makes a run repeatable from its log, beside inputs and outputs: what was asked, and what processes remember."""

import dataclasses
from typing import ClassVar, Self

from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import fields_of
from messaging.control import FaultMessage, Reply
from messaging.generated import nodal_pb2
from messaging.message import Message


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Asked(FaultMessage):
    """What an operator asked of the service with this key, and what was answered; or a signal with this key that was obeyed.

    `request` are the bytes of the service's request type. `time_ns` is that of the controller's cycle which answered, or
    the Unix time at which another process did.
    """

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.Asked

    time_ns: int
    service: str
    request: bytes
    accepted: bool
    state: str
    reason: str

    @classmethod
    def of(cls, service: str, request: bytes, reply: Reply, time_ns: int) -> Self:
        """This request with this answer."""
        return cls(
            time_ns=time_ns,
            service=service,
            request=request,
            **{field.name: getattr(reply, field.name) for field in fields_of(Reply)},
        )

    @property
    def reply(self) -> Reply:
        """What was answered."""
        return Reply(**{field.name: getattr(self, field.name) for field in fields_of(Reply)})


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Memory(Message):
    """What a process carries from one step to the next; said now and then, so that a replay can begin in a log's middle.

    It is what was left by the controller's cycle of this `time_ns`, or by the frame set captured then, whose state or
    shape was the publication of this number. `content` is a snapshot (messaging/snapshot.py) of the process' own type.
    """

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.Memory

    time_ns: int
    content: bytes
    publication: int
