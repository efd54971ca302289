"""One publication as it was recorded."""

import dataclasses
import re
from functools import cache, cached_property
from pathlib import Path

from messaging.message import Message
from messaging.topics import TOPICS, Topic
from recordings.errors import UnknownTopicError


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Recorded:
    """One publication: its topic's key, its bytes as they were on the wire, Unix times, the publisher's number (32 bits)."""

    path: Path
    topic: str
    schema: str
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    payload: bytes

    @cached_property
    def message(self) -> Message:
        """The message, decoded when asked for; raises UnknownTopicError, CodecError or InvalidMessageError."""
        topic = topic_of(self.topic)
        if topic is None:
            raise UnknownTopicError(self.path, f"this version knows no topic {self.topic!r}")
        expected = topic.type.protobuf.DESCRIPTOR.full_name
        if self.schema != expected:
            raise UnknownTopicError(
                self.path,
                f"topic {self.topic!r} holds {self.schema or 'no known type'}; this version reads {expected}",
            )
        return topic.type.from_bytes(self.payload)


def topic_of(key: str) -> Topic | None:
    """The topic of the table that a recorded key belongs to."""
    return next((topic for topic in TOPICS if names(topic, key)), None)


@cache
def names(topic: Topic, key: str) -> bool:
    """True when this key is one of the topic's."""
    pattern = "[^/]+".join(re.escape(piece) for piece in topic.key.split("*"))
    return re.fullmatch(pattern, key) is not None
