"""Recorded messages as the type that their topic is known to carry."""

from typing import TypeVar

from messaging.message import Message, parse
from recordings.errors import UnknownTopicError
from recordings.reader import Recorded

M = TypeVar("M", bound=Message)


def read(recorded: Recorded, kind: type[M]) -> M:
    """The message; raises UnknownTopicError when it is of another type, CodecError or InvalidMessageError."""
    message = recorded.message
    if not isinstance(message, kind):
        raise UnknownTopicError(
            recorded.path, f"topic {recorded.topic!r} holds a {type(message).__name__}, not a {kind.__name__}"
        )
    return message


def time_ns_in(recorded: Recorded, kind: type[Message]) -> int:
    """The message's `time_ns` alone, at a fraction of the cost; raises CodecError."""
    time_ns: int = parse(kind.protobuf, recorded.payload).time_ns
    return time_ns
