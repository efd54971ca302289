"""Finds the next record that can be believed, behind bytes that can not."""

import re

from mcap.opcode import Opcode

from recordings.errors import DamagedRecordingError
from recordings.records import Place, record_at
from recordings.source import Source
from recordings.stored_chunk import HEAD, StoredChunk, chunk_at, contents

BLOCK = 2**20
CHAIN = 3
"""Records in a row that make a record believed which has no checksum."""

CHECKED = re.compile(rb"[\x06\x09\x0c\x0f](?=.{5}\x00{3})", re.DOTALL)
"""Chunk, attachment, metadata or end of data, with a length below 2**40."""
ANY = re.compile(rb"[\x03-\x06\x09\x0c\x0f](?=.{5}\x00{3})", re.DOTALL)
"""The same, and what may stand outside of chunks in other producers' files."""


def next_record(source: Source, offset: int, *, strict: bool, checked: bool) -> Place | None:
    """The first record at this place or behind it that can be believed; None when there is none. Raises UnreadableError."""
    pattern = CHECKED if checked else ANY
    while offset < source.size:
        block = source.read(offset, BLOCK + HEAD.size)
        for match in pattern.finditer(block):
            place = record_at(source, offset + match.start(), strict=strict)
            if place is not None and believed(source, place, strict=strict, checked=checked):
                return place
        offset += BLOCK
    return None


def believed(source: Source, place: Place, *, strict: bool, checked: bool) -> bool:
    """True when the checksum of this record agrees, or when records follow it in a row where it has none."""
    if place.opcode == Opcode.CHUNK:
        chunk = chunk_at(source, place.offset)
        return chunk is not None and readable(source, chunk, checked=checked)
    if strict and place.opcode in {Opcode.ATTACHMENT, Opcode.METADATA}:
        return True
    for _ in range(CHAIN - 1):
        following = record_at(source, place.end, strict=strict)
        if following is None:
            return place.opcode == Opcode.FOOTER or place.end == source.size
        place = following
    return True


def readable(source: Source, chunk: StoredChunk, *, checked: bool) -> bool:
    """True when its contents agree with their checksum; `checked`: it must have one."""
    try:
        contents(source, chunk, checked=checked)
    except DamagedRecordingError:
        return False
    return True
