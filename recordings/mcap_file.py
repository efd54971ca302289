"""An MCAP file in the making: chunks of messages with their index, attachments, metadata, and the summary at its end.

The mcap library's own writer cannot repeat schemas and channels, and copies each payload several times. Here what
describes the messages stands in the file again every few seconds, so that a damaged chunk takes no more than itself.
Every record but the chunk is the library's. Format: https://mcap.dev/spec
"""

import struct
import zlib
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Protocol

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC as MAGIC

from recordings.chunk import Chunk, Packing

REPEAT_NS = 5_000_000_000
FOOTER_HEAD = struct.Struct("<BQQQ")
FOOTER_BYTES = 20


class Stream(Protocol):
    """Where the file goes; it is handed whole records."""

    def write(self, data: bytes) -> int:
        """Append them."""
        ...

    def tell(self) -> int:
        """Bytes written so far."""
        ...


class McapFile:
    """One file. Times are Unix ns; raises what the stream raises."""

    def __init__(self, stream: Stream, chunk_bytes: int, packing: Packing) -> None:
        """Begin the file; a chunk is closed once it holds that many bytes."""
        self._stream = stream
        self._chunk_bytes = chunk_bytes
        self._packing = packing
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: Counter[int] = Counter()
        self._ends: list[tuple[int, int]] = [(0, 0)]
        self._chunk = Chunk()
        self._repeat_at_ns = 0
        self._introduced = False
        stream.write(MAGIC + _bytes_of([Header("", "nodal")]))

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        """Make a schema known; its number."""
        schema = Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data)
        self._schemas.append(schema)
        self._introduce(schema)
        return schema.id

    def channel(
        self, topic: str, encoding: str, schema_id: int, metadata: Mapping[str, str] = MappingProxyType({})
    ) -> int:
        """Make a channel known; its number. `schema_id` is 0 for messages without a schema."""
        number = len(self._channels) + 1
        channel = Channel(
            id=number, topic=topic, message_encoding=encoding, metadata=dict(metadata), schema_id=schema_id
        )
        self._channels.append(channel)
        self._introduce(channel)
        return number

    def message(self, channel_id: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Append a message."""
        self._chunk.message(channel_id, sequence, log_ns, publish_ns, data)
        if self._chunk.size >= self._chunk_bytes:
            self.end_chunk()

    def attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Append a file."""
        record = _bytes_of(
            [Attachment(create_time=time_ns, log_time=time_ns, name=name, media_type=media_type, data=data)]
        )
        index = AttachmentIndex(
            offset=self._stream.tell(),
            length=len(record),
            log_time=time_ns,
            create_time=time_ns,
            data_size=len(data),
            name=name,
            media_type=media_type,
        )
        self._attachments.append(index)
        self._stream.write(record)

    def metadata(self, name: str, facts: dict[str, str]) -> None:
        """Append a metadata record."""
        record = _bytes_of([Metadata(name=name, metadata=facts)])
        self._metadata.append(MetadataIndex(offset=self._stream.tell(), length=len(record), name=name))
        self._stream.write(record)

    def end_chunk(self) -> None:
        """Hand on what the chunk holds; nothing happens when that is no message."""
        ended = self._chunk
        if not ended.count:
            return
        block, index = ended.records(self._stream.tell(), self._packing)
        self._stream.write(block)
        self._chunks.append(index)
        self._counts.update(ended.counts())
        self._ends.append((index.chunk_start_offset + index.chunk_length, self._ends[-1][1] + ended.count))
        self._chunk = Chunk()
        # what was said for the first time is said twice at once: the chunk that said it may come to harm
        if self._introduced or ended.last_ns >= self._repeat_at_ns:
            self._introduced = False
            self._repeat_at_ns = ended.last_ns + REPEAT_NS
            self._chunk.describe(_bytes_of([*self._schemas, *self._channels]))

    def messages_within(self, size_bytes: int) -> int:
        """How many messages stand in the whole chunks among the file's first bytes."""
        return self._ends[bisect_right(self._ends, size_bytes, key=lambda end: end[0]) - 1][1]

    def finish(self) -> None:
        """End the file: the last chunk, the summary, the footer."""
        self.end_chunk()
        self._stream.write(_bytes_of([DataEnd(data_section_crc=0)]))
        start = self._stream.tell()
        summary, offsets = b"", []
        for opcode, records in self._summary().items():
            group = _bytes_of(records)
            offsets.append(
                SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(group))
            )
            summary += group
        offset_start = start + len(summary)
        summary += _bytes_of(offsets)
        footer_head = FOOTER_HEAD.pack(Opcode.FOOTER, FOOTER_BYTES, start, offset_start)
        footer = Footer(
            summary_start=start,
            summary_offset_start=offset_start,
            summary_crc=zlib.crc32(footer_head, zlib.crc32(summary)),
        )
        self._stream.write(summary + _bytes_of([footer]) + MAGIC)

    def _introduce(self, record: McapRecord) -> None:
        self._introduced = True
        self._chunk.describe(_bytes_of([record]))

    def _summary(self) -> dict[Opcode, list[McapRecord]]:
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        return {
            Opcode.SCHEMA: [*self._schemas],
            Opcode.CHANNEL: [*self._channels],
            Opcode.STATISTICS: [statistics],
            Opcode.CHUNK_INDEX: [*self._chunks],
            Opcode.ATTACHMENT_INDEX: [*self._attachments],
            Opcode.METADATA_INDEX: [*self._metadata],
        }


def _bytes_of(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
