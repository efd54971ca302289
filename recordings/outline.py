"""Where everything stands in a recording's file: from its index when that can be believed, else by looking for it.

The index at the end of a file is believed when it agrees with its checksum and names every byte between the header and
itself; what it points at is checked when it is read. Any other file is walked through from record to record (walk.py).
"""

from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, Channel, ChunkIndex, Header, McapRecord, MetadataIndex, Schema

from recordings.damage import Damage
from recordings.records import PRODUCER, Place, header_end, header_of, parsed, summary_of
from recordings.source import MAGIC, Source, ends_with_magic
from recordings.stored_chunk import CRC_AT, HEAD, LENGTH32, StoredChunk

DATA_END_BYTES = HEAD.size + LENGTH32.size
NOT_AT_THE_BEGINNING = "the file does not begin as MCAP files do"


@dataclass(kw_only=True)
class Outline:
    """What a file holds, by place, and the damage that was seen so far.

    `strict`: it is held to what our own recorder writes. `checked`: chunks without a checksum are refused.
    `indexed`: it was taken from the file's index. `schemas` and `channels` are those that stand outside of chunks.
    """

    source: Source
    strict: bool
    checked: bool
    indexed: bool = False
    chunks: list[StoredChunk] = field(default_factory=list)
    attachments: list[Place] = field(default_factory=list)
    metadata: list[Place] = field(default_factory=list)
    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    damage: list[Damage] = field(default_factory=list)

    def note(self, begin: int, end: int, problem: str) -> Damage:
        """Add a damage, unless it is known already."""
        for known in self.damage:
            if (known.offset, known.problem) == (begin, problem):
                return known
        damage = Damage(path=self.source.path, offset=begin, length=end - begin, problem=problem)
        self._date(damage)
        self.damage.append(damage)
        self.damage.sort(key=lambda damage: damage.offset)
        return damage

    def settle(self) -> None:
        """Put the chunks in order of log time; say of each damage between which times it lies."""
        self.chunks.sort(key=lambda chunk: (chunk.start_ns, chunk.offset))
        for damage in self.damage:
            self._date(damage)

    def describe(self, records: list[McapRecord]) -> None:
        """Take in schemas and channels."""
        self.schemas += [record for record in records if isinstance(record, Schema)]
        self.channels += [record for record in records if isinstance(record, Channel)]

    def _date(self, damage: Damage) -> None:
        before = [chunk.end_ns for chunk in self.chunks if chunk.offset < damage.offset]
        after = [chunk.start_ns for chunk in self.chunks if chunk.offset > damage.offset]
        damage.start_ns, damage.end_ns = max(before, default=None), min(after, default=None)


def is_strict(header: Header | None) -> bool:
    """True for our own recordings, and for files that do not say whose they are."""
    return header is None or header.library == PRODUCER


def indexed(source: Source) -> Outline | None:
    """The outline that a file's own index gives; None when it has none that can be believed. Raises UnreadableError."""
    header = header_of(source)
    summary = summary_of(source, strict=True) if header and ends_with_magic(source) else None
    if header is None or summary is None:
        return None
    strict = is_strict(header)
    outline = Outline(source=source, strict=strict, checked=strict, indexed=True)
    pieces: list[tuple[int, int]] = []
    for record in summary.records:
        match record:
            case ChunkIndex() as index:
                outline.chunks.append(_from_index(index))
                pieces.append((index.chunk_start_offset, index.chunk_length + index.message_index_length))
            case AttachmentIndex(offset=offset, length=length):
                outline.attachments.append(Place(opcode=Opcode.ATTACHMENT, offset=offset, length=length))
                pieces.append((offset, length))
            case MetadataIndex(offset=offset, length=length):
                outline.metadata.append(Place(opcode=Opcode.METADATA, offset=offset, length=length))
                pieces.append((offset, length))
    if not _seamless(pieces, header_end(source), summary.offset - DATA_END_BYTES):
        return None
    outline.describe(summary.records)
    outline.settle()
    if outline.chunks:
        crc = source.read(outline.chunks[0].offset + CRC_AT, LENGTH32.size)
        outline.checked |= any(crc)
    if source.read(0, len(MAGIC)) != MAGIC:
        outline.note(0, len(MAGIC), NOT_AT_THE_BEGINNING)
    return outline


def attached(outline: Outline, source: Source, places: list[Place]) -> list[McapRecord]:
    """The attachments or metadata at these places; what is damaged is noted and left out. Raises UnreadableError."""
    found = []
    for place in places:
        record = parsed(source, place, strict=outline.strict)
        if record is None:
            outline.note(place.offset, place.end, damaged(place.opcode))
        else:
            found.append(record)
    return found


def damaged(opcode: int) -> str:
    """What to say of a record of this kind that does not make sense."""
    if opcode not in set(Opcode):
        return "bytes that are no record"
    name = Opcode(opcode).name.lower().replace("_", " ")
    return f"a damaged record: {name}"


def _seamless(pieces: list[tuple[int, int]], begin: int, end: int) -> bool:
    for offset, length in sorted(pieces):
        if offset != begin:
            return False
        begin += length
    return begin == end


def _from_index(index: ChunkIndex) -> StoredChunk:
    return StoredChunk(
        offset=index.chunk_start_offset,
        length=index.chunk_length,
        start_ns=index.message_start_time,
        end_ns=index.message_end_time,
        compression=index.compression,
        unpacked=index.uncompressed_size,
        body=index.chunk_start_offset + index.chunk_length - index.compressed_size,
    )
