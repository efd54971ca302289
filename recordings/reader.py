"""Reads recordings: lazily, in the order of their writing, whether they were finished or cut off."""

import dataclasses
import re
from collections.abc import Collection, Iterator
from functools import cache, cached_property
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from messaging.message import Message
from messaging.topics import TOPICS, Topic
from recordings.errors import UnknownTopicError
from recordings.records import messages_with_channels, records


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
                self.path, f"topic {self.topic!r} holds {self.schema}; this version reads {expected}"
            )
        return topic.type.from_bytes(self.payload)


def messages(path: Path, topics: Collection[Topic] | None = None) -> Iterator[Recorded]:
    """Every publication of these topics (None: of all), in the order of recording; log times never decrease.

    What a killed recorder did not write whole is left out. Raises UnreadableError, and DamagedRecordingError once
    everything before the damage was handed out.
    """
    for schema, channel, message in messages_with_channels(path):
        if topics is None or any(_names(topic, channel.topic) for topic in topics):
            yield Recorded(
                path=path,
                topic=channel.topic,
                schema=schema.name,
                log_time_ns=message.log_time,
                publish_time_ns=message.publish_time,
                sequence=message.sequence,
                payload=message.data,
            )


def attachments(path: Path) -> dict[str, bytes]:
    """The files in the recording by name: bench file and calibration; raises as `messages` does."""
    found = (record for _, record in records(path, {Opcode.ATTACHMENT}))
    return {record.name: record.data for record in found if isinstance(record, Attachment)}


def metadata(path: Path) -> dict[str, dict[str, str]]:
    """The recorder's notes by name (see recordings.process); without SUMMARY when it was killed; raises as `messages` does."""
    found = (record for _, record in records(path, {Opcode.METADATA}))
    return {record.name: record.metadata for record in found if isinstance(record, Metadata)}


def topic_of(key: str) -> Topic | None:
    """The topic of the table that a recorded key belongs to."""
    return next((topic for topic in TOPICS if _names(topic, key)), None)


@cache
def _names(topic: Topic, key: str) -> bool:
    pattern = "[^/]+".join(re.escape(piece) for piece in topic.key.split("*"))
    return re.fullmatch(pattern, key) is not None
