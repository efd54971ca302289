"""A chunk of an MCAP file in the making. A message's payload is copied once, when the chunk is put together. Pure."""

import struct
import zlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import ChunkIndex

HEAD = struct.Struct("<BQ")
"""Opcode and length of the record that follows."""
MESSAGE = struct.Struct("<BQHIQQ")
TIMES_SIZE_CRC = struct.Struct("<QQQI")
CHANNEL_AND_LENGTH = struct.Struct("<HI")
INDEX_ENTRY_BYTES = 16


@dataclass(frozen=True, kw_only=True)
class Packing:
    """How the contents of a chunk are stored: MCAP's name of the compression, and what does it."""

    name: str = ""
    compress: Callable[[bytes], bytes] | None = None


@dataclass
class Chunk:
    """Messages, the log times (Unix ns) that they lie between, and the records that describe them."""

    size: int = 0
    count: int = 0
    first_ns: int = 0
    last_ns: int = 0
    _pieces: list[bytes] = field(default_factory=list)
    _entries: defaultdict[int, list[int]] = field(default_factory=lambda: defaultdict(list))

    def describe(self, records: bytes) -> None:
        """Append schemas and channels."""
        self._pieces.append(records)
        self.size += len(records)

    def message(self, channel_id: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Append a message."""
        self.first_ns = min(log_ns, self.first_ns) if self.count else log_ns
        self.last_ns = max(log_ns, self.last_ns)
        self.count += 1
        self._entries[channel_id] += (log_ns, self.size)
        length = MESSAGE.size + len(data)
        head = MESSAGE.pack(Opcode.MESSAGE, length - HEAD.size, channel_id, sequence, log_ns, publish_ns)
        self._pieces += (head, data)
        self.size += length

    def counts(self) -> dict[int, int]:
        """How many messages each channel has."""
        return {channel_id: len(entries) // 2 for channel_id, entries in self._entries.items()}

    def records(self, start: int, packing: Packing) -> tuple[bytes, ChunkIndex]:
        """The chunk and its message indexes as they stand in the file from byte `start` on, and what finds them there."""
        crc = 0
        for piece in self._pieces:
            crc = zlib.crc32(piece, crc)
        pieces, stored = self._pieces, self.size
        if packing.compress is not None:
            pieces = [packing.compress(b"".join(pieces))]
            stored = len(pieces[0])
        name = packing.name.encode()
        body = TIMES_SIZE_CRC.pack(self.first_ns, self.last_ns, self.size, crc)
        body += struct.pack("<I", len(name)) + name + struct.pack("<Q", stored)
        head = HEAD.pack(Opcode.CHUNK, len(body) + stored) + body
        length = len(head) + stored
        indexes, offsets = self._indexes(start + length)
        index = ChunkIndex(
            chunk_length=length,
            chunk_start_offset=start,
            compression=packing.name,
            compressed_size=stored,
            message_end_time=self.last_ns,
            message_index_length=len(indexes),
            message_index_offsets=offsets,
            message_start_time=self.first_ns,
            uncompressed_size=self.size,
        )
        return b"".join((head, *pieces, indexes)), index

    def _indexes(self, start: int) -> tuple[bytes, dict[int, int]]:
        indexes, offsets = b"", {}
        for channel_id, entries in self._entries.items():
            offsets[channel_id] = start + len(indexes)
            length = len(entries) // 2 * INDEX_ENTRY_BYTES
            indexes += HEAD.pack(Opcode.MESSAGE_INDEX, CHANNEL_AND_LENGTH.size + length)
            indexes += CHANNEL_AND_LENGTH.pack(channel_id, length)
            indexes += struct.pack(f"<{len(entries)}Q", *entries)
        return indexes, offsets
