"""Records of an MCAP file as they stand in it, and whether the bytes at a place can be one.

Format: https://mcap.dev/spec
"""

import struct
import zlib
from dataclasses import dataclass
from io import BytesIO
from typing import Any

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
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

from recordings.metadata import CHECKSUM, unbroken
from recordings.source import MAGIC, Source
from recordings.stored_chunk import HEAD, LARGEST_BYTES, LENGTH32, MESSAGE, chunk_at, records_in

KINDS: dict[Opcode, Any] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
    Opcode.DATA_END: DataEnd,
}
MALFORMED = (McapError, struct.error, ValueError, OverflowError, LookupError)
INDEX_HEAD = struct.Struct("<HI")
INDEX_ENTRY_BYTES = 16
FOOTER_BYTES = HEAD.size + 20
FIRST_UNKNOWN = 0x10
PRODUCER = "nodal"
"""The library that our recordings name in their header."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Place:
    """One record: `length` bytes from `offset`, its head of opcode and length included."""

    opcode: int
    offset: int
    length: int

    @property
    def end(self) -> int:
        """The byte after it."""
        return self.offset + self.length


def record_at(source: Source, offset: int, *, strict: bool) -> Place | None:
    """The record that begins here; None when these bytes can be none.

    `strict` is what our own recordings are held to: no records but those that their writer knows, and none with rests.
    What a chunk holds is not looked into.
    """
    head = source.read(offset, HEAD.size)
    if len(head) < HEAD.size:
        return None
    opcode, length = HEAD.unpack(head)
    place = Place(opcode=opcode, offset=offset, length=HEAD.size + length)
    if place.end > source.size:
        return None
    if opcode == Opcode.CHUNK:
        chunk = chunk_at(source, offset)
        sound = chunk is not None and chunk.end == place.end
    elif opcode == Opcode.MESSAGE_INDEX:
        sound = _is_message_index(source, place)
    elif opcode in KINDS:
        sound = parsed(source, place, strict=strict) is not None
    elif opcode == Opcode.MESSAGE:
        sound = not strict and length >= MESSAGE.size
    else:
        sound = not strict and opcode >= FIRST_UNKNOWN
    return place if sound else None


def parsed(source: Source, place: Place, *, strict: bool) -> McapRecord | None:
    """The record at this place, when writing it again gives the same bytes and its checksum agrees; else None."""
    if place.length > LARGEST_BYTES:
        return None
    return record_of(source.read(place.offset, place.length), strict=strict)


def is_whole(source: Source, place: Place) -> bool:
    """True of an attachment all of whose lengths agree: it is damaged in its contents then, and ends where it says."""
    if place.opcode != Opcode.ATTACHMENT or place.end > source.size or place.length > LARGEST_BYTES:
        return False
    try:
        record = Attachment.read(ReadDataStream(BytesIO(source.read(place.offset + HEAD.size, place.length))))
    except MALFORMED:
        return False
    return len(bytes_of(record)) == place.length


def record_of(data: bytes, *, strict: bool) -> McapRecord | None:
    """The record that these bytes are, head included, when writing it again gives the same ones; else None."""
    try:
        record: McapRecord = KINDS[Opcode(data[0])].read(ReadDataStream(BytesIO(data[HEAD.size :])))
        again = bytes_of(record)
    except MALFORMED:
        return None
    if isinstance(record, Attachment):
        # its last field is the checksum, which another producer may leave out
        unchecked = not strict and data[-LENGTH32.size :] == bytes(LENGTH32.size)
        return record if data == again or (unchecked and data[:-4] == again[:-4]) else None
    # a later version of MCAP may have put more fields behind those that are known
    same = data == again if strict else data[HEAD.size :].startswith(again[HEAD.size :])
    if isinstance(record, Metadata) and same:
        same = unbroken(record.metadata) and (not strict or CHECKSUM in record.metadata)
    return record if same else None


def bytes_of(record: McapRecord) -> bytes:
    """The record as it stands in a file, head included."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def header_of(source: Source) -> Header | None:
    """What the file says of itself at its beginning; None when that is damaged."""
    place = record_at(source, len(MAGIC), strict=False)
    header = parsed(source, place, strict=False) if place else None
    return header if isinstance(header, Header) else None


def header_end(source: Source) -> int:
    """The byte after the header."""
    place = record_at(source, len(MAGIC), strict=False)
    return place.end if place else len(MAGIC)


@dataclass(frozen=True, kw_only=True)
class Summary:
    """The records between the data and the footer, and where they begin."""

    offset: int
    records: list[McapRecord]


def summary_of(source: Source, *, strict: bool) -> Summary | None:
    """The summary at the end of the file, when it agrees with its checksum; else None. It may be empty."""
    footer_at = source.size - FOOTER_BYTES - len(MAGIC)
    data = source.read(footer_at, FOOTER_BYTES) if footer_at > 0 else b""
    footer = record_of(data, strict=True) if data else None
    if not isinstance(footer, Footer):
        return None
    begin = footer.summary_start or footer_at
    if begin > footer_at or footer_at - begin > LARGEST_BYTES:
        return None
    summary = source.read(begin, footer_at - begin)
    if footer.summary_crc != zlib.crc32(data[:-4], zlib.crc32(summary)) and (strict or footer.summary_crc):
        return None
    try:
        pieces = [summary[start:end] for _, start, end in records_in(summary)]
    except ValueError:
        return None
    records = [record_of(piece, strict=False) for piece in pieces]
    return Summary(offset=begin, records=[record for record in records if record is not None])


def _is_message_index(source: Source, place: Place) -> bool:
    data = source.read(place.offset + HEAD.size, INDEX_HEAD.size)
    if len(data) < INDEX_HEAD.size:
        return False
    _, length = INDEX_HEAD.unpack(data)
    return bool(length % INDEX_ENTRY_BYTES == 0 and place.length == HEAD.size + INDEX_HEAD.size + length)
