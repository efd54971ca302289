"""What the channels of a file carry: topics and schemas by number, as far as they are described somewhere."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from mcap.records import Channel, McapRecord, Schema


@dataclass(frozen=True, kw_only=True)
class Stream:
    """A channel as its producer described it. `schema` is the name of the messages' type; empty when it has none."""

    topic: str
    encoding: str
    metadata: Mapping[str, str] = field(default_factory=dict, hash=False)
    schema: str = ""
    schema_encoding: str = ""
    schema_data: bytes = field(default=b"", repr=False)


class Streams:
    """Fills from schema and channel records in any order; a later description takes the place of an earlier one."""

    def __init__(self, records: Iterable[McapRecord]) -> None:
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._known: dict[int, Stream] = {}
        for record in records:
            self.take(record)

    def take(self, record: McapRecord) -> None:
        """Take in one description."""
        if isinstance(record, Schema) and self._schemas.get(record.id) != record:
            self._schemas[record.id] = record
            self._known.clear()
        elif isinstance(record, Channel) and self._channels.get(record.id) != record:
            self._channels[record.id] = record
            self._known.pop(record.id, None)

    def of(self, channel_id: int) -> Stream | None:
        """The stream of this channel; None when it, or its schema, was not described."""
        if channel_id not in self._known:
            channel = self._channels.get(channel_id)
            schema = self._schemas.get(channel.schema_id) if channel else None
            if channel is None or (schema is None and channel.schema_id):
                return None
            self._known[channel_id] = _stream(channel, schema)
        return self._known[channel_id]


def _stream(channel: Channel, schema: Schema | None) -> Stream:
    return Stream(
        topic=channel.topic,
        encoding=channel.message_encoding,
        metadata=channel.metadata,
        schema=schema.name if schema else "",
        schema_encoding=schema.encoding if schema else "",
        schema_data=schema.data if schema else b"",
    )
