"""A chunk as it stands in a file: its head, its contents once they agree with their checksum, the records in them."""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import lz4.frame
import zstandard
from mcap.opcode import Opcode

from recordings.errors import DamagedRecordingError
from recordings.source import Source

HEAD = struct.Struct("<BQ")
"""Opcode and length of the record that follows."""
TIMES_SIZE_CRC = struct.Struct("<QQQI")
LENGTH32, LENGTH64 = struct.Struct("<I"), struct.Struct("<Q")
CRC_AT = HEAD.size + TIMES_SIZE_CRC.size - LENGTH32.size
LONGEST_NAME = 16
LARGEST_BYTES = 2**30
"""More than this in one chunk, stored or unpacked, is refused: a damaged length must not fill the memory."""

LOOSE = "loose messages"
HEAD_DAMAGED = "the head of a chunk is damaged; its messages are whole"
MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence number, log time and publish time of a message, behind the head of its record."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredChunk:
    """Where a chunk stands, in bytes of the file, and what its head says. `start_ns` and `end_ns` are log times.

    A run of messages that stand in the file without a chunk around them is one too: its `compression` is LOOSE.
    """

    offset: int
    length: int
    start_ns: int
    end_ns: int
    compression: str
    unpacked: int
    body: int

    @property
    def end(self) -> int:
        """The byte after it."""
        return self.offset + self.length


def chunk_at(source: Source, offset: int) -> StoredChunk | None:
    """The chunk whose record begins here, by the lengths inside its head; None when they make no sense."""
    longest = HEAD.size + TIMES_SIZE_CRC.size + LENGTH32.size + LONGEST_NAME + LENGTH64.size
    data = source.read(offset, longest)
    place = HEAD.size + TIMES_SIZE_CRC.size
    if len(data) < place + LENGTH32.size:
        return None
    start_ns, end_ns, unpacked, _ = TIMES_SIZE_CRC.unpack_from(data, HEAD.size)
    (named,) = LENGTH32.unpack_from(data, place)
    place += LENGTH32.size + named
    if named > LONGEST_NAME or len(data) < place + LENGTH64.size:
        return None
    (stored,) = LENGTH64.unpack_from(data, place)
    body = offset + place + LENGTH64.size
    if body + stored > source.size:
        return None
    return StoredChunk(
        offset=offset,
        length=body + stored - offset,
        start_ns=start_ns,
        end_ns=end_ns,
        compression=data[place - named : place].decode("ascii", errors="replace"),
        unpacked=unpacked,
        body=body,
    )


def contents(source: Source, chunk: StoredChunk, *, checked: bool) -> tuple[memoryview, bool]:
    """The records in it, and whether its head says what it should; `checked` refuses a chunk without a checksum.

    Raises DamagedRecordingError, UnreadableError.
    """
    if chunk.length > LARGEST_BYTES:
        raise _damaged(source, chunk, f"it is larger than {LARGEST_BYTES} bytes")
    stored = source.read(chunk.offset, chunk.length)
    if len(stored) != chunk.length:
        raise _damaged(source, chunk, "the file became shorter while it was read")
    body = memoryview(stored)[chunk.body - chunk.offset :]
    if chunk.compression == LOOSE:
        return body, True
    try:
        data = _unpacked(body, chunk.compression, chunk.unpacked)
    except (RuntimeError, ValueError, zstandard.ZstdError, MemoryError) as error:
        raise _damaged(source, chunk, f"it cannot be unpacked: {error}") from error
    (crc,) = LENGTH32.unpack_from(stored, CRC_AT)
    if zlib.crc32(data) != crc and (checked or crc):
        raise _damaged(source, chunk, "its contents do not agree with their checksum")
    return data, stored.startswith(_head(chunk, crc)) and len(data) == chunk.unpacked


def records_in(data: bytes | memoryview) -> Iterator[tuple[int, int, int]]:
    """Opcode, beginning and end (head included) of each record; raises ValueError when the last is not whole."""
    place, size = 0, len(data)
    while place + HEAD.size <= size:
        opcode, length = HEAD.unpack_from(data, place)
        end = place + HEAD.size + length
        if end > size or (opcode == Opcode.MESSAGE and length < MESSAGE.size):
            break
        yield opcode, place, end
        place = end
    if place != size:
        raise ValueError(f"its records end {size - place} bytes before it does")


def times_in(data: memoryview) -> tuple[int, int]:
    """The log times between which the messages in a chunk's contents lie; raises ValueError when there are none."""
    times = [
        MESSAGE.unpack_from(data, begin + HEAD.size)[2]
        for opcode, begin, _ in records_in(data)
        if opcode == Opcode.MESSAGE
    ]
    return min(times), max(times)


def _head(chunk: StoredChunk, crc: int) -> bytes:
    name = chunk.compression.encode()
    return (
        HEAD.pack(Opcode.CHUNK, chunk.length - HEAD.size)
        + TIMES_SIZE_CRC.pack(chunk.start_ns, chunk.end_ns, chunk.unpacked, crc)
        + LENGTH32.pack(len(name))
        + name
        + LENGTH64.pack(chunk.end - chunk.body)
    )


def _unpacked(data: memoryview, compression: str, size: int) -> memoryview:
    if not compression:
        return data
    if compression == "lz4":
        size = lz4.frame.get_frame_info(data)["content_size"] or size
        _check_size(size)
        decompressor = lz4.frame.LZ4FrameDecompressor()
        unpacked = decompressor.decompress(data, max_length=size)
        if not decompressor.eof or decompressor.unused_data:
            raise ValueError("its compressed data do not end where it does")
        return memoryview(unpacked)
    if compression == "zstd":
        parameters = zstandard.get_frame_parameters(data)
        known = parameters.content_size not in {0, zstandard.CONTENTSIZE_UNKNOWN}
        size = parameters.content_size if known else size
        _check_size(size)
        return memoryview(
            zstandard.ZstdDecompressor().decompress(data, max_output_size=size, allow_extra_data=False)
        )
    raise ValueError(f"compression {compression!r} is not known; known are lz4, zstd and none")


def _check_size(size: int) -> None:
    if size > LARGEST_BYTES:
        raise ValueError(f"it claims to hold {size} bytes; allowed are {LARGEST_BYTES}")


def _damaged(source: Source, chunk: StoredChunk, problem: str) -> DamagedRecordingError:
    return DamagedRecordingError(source.path, chunk.offset, f"a damaged chunk: {problem}")
