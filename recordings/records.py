"""The records of an MCAP file, one after another as they stand in it, as far as the file goes.

A recorder that was killed leaves a file without an end: that is no damage, its last record is left out. Anything else
that is not MCAP is a DamagedRecordingError naming the place. The index at the end is not used, so a file that was cut
off reads like any other. Format: https://mcap.dev/spec
"""

import os
import struct
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, cast

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC as MAGIC

from recordings.errors import DamagedRecordingError, UnreadableError

HEAD = struct.Struct("<BQ")
"""Opcode and length of the record that follows."""

PARSERS = {Opcode.ATTACHMENT: Attachment.read, Opcode.CHUNK: Chunk.read, Opcode.METADATA: Metadata.read}

OPCODES = frozenset(Opcode)

MALFORMED = (McapError, struct.error, ValueError, RuntimeError, MemoryError, LookupError)


def records(path: Path, wanted: Collection[Opcode]) -> Iterator[tuple[int, McapRecord]]:
    """Offset and record of each attachment, chunk or metadata wanted; raises UnreadableError, DamagedRecordingError."""
    with open_to_read(path) as file:
        size = file.seek(0, os.SEEK_END)
        closed = _ends_with_magic(file, size)
        _check_magic(path, file)
        offset = len(MAGIC)
        while offset + HEAD.size <= size:
            opcode, length = HEAD.unpack(file.read(HEAD.size))
            end = offset + HEAD.size + length
            if opcode not in OPCODES:
                raise DamagedRecordingError(path, offset, f"there is no record type {opcode}")
            if end > size and closed:
                raise DamagedRecordingError(path, offset, f"a record of {length} bytes reaches past the end")
            if end > size or opcode == Opcode.FOOTER:
                return
            if opcode in wanted:
                yield offset, _parsed(path, offset, Opcode(opcode), file.read(length))
            offset = file.seek(end)


def messages_with_channels(path: Path) -> Iterator[tuple[Schema, Channel, Message]]:
    """Every message of the file with what describes it; raises UnreadableError, DamagedRecordingError."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for offset, chunk in records(path, {Opcode.CHUNK}):
        with _whole(path, offset, "chunk"):
            contents = breakup_chunk(cast("Chunk", chunk), validate_crc=True)
        for record in contents:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                with _whole(path, offset, "message"):
                    channel = channels[record.channel_id]
                    schema = schemas[channel.schema_id]
                yield schema, channel, record


def finished(path: Path) -> bool:
    """True when the recorder ended the file itself; raises UnreadableError."""
    with open_to_read(path) as file:
        return _ends_with_magic(file, file.seek(0, os.SEEK_END))


def open_to_read(path: Path) -> IO[bytes]:
    """The file; raises UnreadableError."""
    try:
        return path.open("rb")
    except OSError as error:
        raise UnreadableError(path, f"it cannot be read: {error.strerror}") from error


def _parsed(path: Path, offset: int, opcode: Opcode, body: bytes) -> McapRecord:
    with _whole(path, offset, opcode.name.lower()):
        return cast("McapRecord", PARSERS[opcode](ReadDataStream(BytesIO(body))))


@contextmanager
def _whole(path: Path, offset: int, kind: str) -> Iterator[None]:
    """Turn what mcap and its decompressors raise on bytes that are not what they claim to be into one error."""
    try:
        yield
    except MALFORMED as error:
        raise DamagedRecordingError(
            path, offset, f"a {kind} cannot be read: {error or type(error).__name__}"
        ) from error


def _check_magic(path: Path, file: IO[bytes]) -> None:
    file.seek(0)
    magic = file.read(len(MAGIC))
    # nothing at all is what a recorder leaves that was killed at its very start
    if magic and magic != MAGIC:
        raise DamagedRecordingError(path, 0, f"it begins with {magic.hex(' ')}; it is not an MCAP file")


def _ends_with_magic(file: IO[bytes], size: int) -> bool:
    file.seek(max(size - len(MAGIC), 0))
    return size > len(MAGIC) and file.read() == MAGIC
