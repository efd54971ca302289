"""Walks through a recording's file from record to record, over damaged stretches too.

A record is passed over by its length. When what follows can be no record, either that length was wrong or bytes were
changed, lost or added: then the next record is searched for that can be believed.
"""

import dataclasses
import struct

from mcap.opcode import Opcode

from recordings.errors import DamagedRecordingError
from recordings.outline import NOT_AT_THE_BEGINNING, Outline, damaged, is_strict
from recordings.records import INDEX_HEAD, Place, header_of, parsed, record_at, summary_of
from recordings.search import believed, next_record, readable
from recordings.source import MAGIC, Source, ends_with_magic
from recordings.stored_chunk import (
    CRC_AT,
    HEAD,
    HEAD_DAMAGED,
    LENGTH32,
    LOOSE,
    StoredChunk,
    chunk_at,
    contents,
    times_in,
)

LONGEST_RUN = 2**20
INDEX_ENTRY = struct.Struct("<QQ")
LOG_TIME_AT = HEAD.size + 6


def walked(source: Source) -> Outline:
    """The outline of a file; raises DamagedRecordingError when nothing of an MCAP file is in it, UnreadableError."""
    walk = _Walk(source)
    walk.run()
    return walk.outline


class _Walk:
    def __init__(self, source: Source) -> None:
        strict = is_strict(header_of(source))
        self.outline = Outline(source=source, strict=strict, checked=strict)
        self._source = source
        self._heads: set[bytes] = set()
        self._last = Place(opcode=0, offset=0, length=0)
        self._indexed_ns: dict[int, list[int]] = {}
        if summary := summary_of(source, strict=strict):
            self.outline.describe(summary.records)

    def run(self) -> None:
        place: int | None = self._begin()
        while place is not None and place < self._source.size:
            record = self._record_at(place)
            place = self._take(record) if record else self._search(place)
        if place is not None:
            self.outline.note(place, place, "the file was cut off here, it has no end")
        self._check_times()
        self.outline.settle()

    def _record_at(self, place: int) -> Place | None:
        record = record_at(self._source, place, strict=self.outline.strict)
        loose = record is not None and record.opcode == Opcode.MESSAGE
        return None if loose and self.outline.checked else record

    def _begin(self) -> int:
        """Where the first record should be."""
        source = self._source
        magic = source.read(0, len(MAGIC))
        if MAGIC.startswith(magic):
            return len(magic)
        if header_of(source) is not None:
            self.outline.note(0, len(MAGIC), NOT_AT_THE_BEGINNING)
            return len(MAGIC)
        if next_record(source, 0, strict=True, checked=True) is None:
            raise DamagedRecordingError(
                source.path, 0, f"it begins with {magic.hex(' ')}; it is not an MCAP file"
            )
        return 0

    def _take(self, record: Place) -> int | None:
        """Put the record where it belongs; where the next should be, None at the end of the data."""
        outline, source = self.outline, self._source
        match record.opcode:
            case Opcode.CHUNK:
                self._take_chunk(record)
            case Opcode.MESSAGE_INDEX:
                self._take_index(record)
            case Opcode.MESSAGE:
                self._take_loose(record)
            case Opcode.ATTACHMENT:
                outline.attachments.append(record)
            case Opcode.METADATA:
                outline.metadata.append(record)
            case Opcode.SCHEMA | Opcode.CHANNEL:
                if described := parsed(source, record, strict=outline.strict):
                    outline.describe([described])
            case Opcode.DATA_END | Opcode.FOOTER:
                return self._end(record)
        self._last = record
        return record.end

    def _take_chunk(self, record: Place) -> None:
        chunk = chunk_at(self._source, record.offset)
        if chunk is None:
            return
        self.outline.checked |= any(self._source.read(chunk.offset + CRC_AT, LENGTH32.size))
        head = self._source.read(chunk.offset, chunk.body - chunk.offset)
        if self.outline.checked and head in self._heads:
            self.outline.note(record.offset, record.end, "a chunk that stands in the file twice")
            return
        self._heads.add(head)
        self.outline.chunks.append(chunk)

    def _take_index(self, record: Place) -> None:
        if self.outline.chunks:
            begin = record.offset + HEAD.size + INDEX_HEAD.size
            entries = INDEX_ENTRY.iter_unpack(self._source.read(begin, record.end - begin))
            self._indexed_ns.setdefault(self.outline.chunks[-1].offset, []).extend(
                time for time, _ in entries
            )

    def _take_loose(self, record: Place) -> None:
        time_ns = int.from_bytes(self._source.read(record.offset + LOG_TIME_AT, 8), "little")
        run = StoredChunk(
            offset=record.offset,
            length=record.length,
            start_ns=time_ns,
            end_ns=time_ns,
            compression=LOOSE,
            unpacked=record.length,
            body=record.offset,
        )
        last = self.outline.chunks[-1] if self.outline.chunks else None
        if last and (last.compression, last.end) == (LOOSE, record.offset) and last.length < LONGEST_RUN:
            run = dataclasses.replace(
                last,
                length=last.length + record.length,
                start_ns=min(last.start_ns, time_ns),
                end_ns=max(last.end_ns, time_ns),
            )
            self.outline.chunks.pop()
        self.outline.chunks.append(run)

    def _end(self, record: Place) -> int | None:
        """The data ends here, when the summary is where it should be."""
        summary = summary_of(self._source, strict=self.outline.strict)
        if (
            summary
            and ends_with_magic(self._source)
            and record.end in {summary.offset, self._source.size - len(MAGIC)}
        ):
            return None
        following = self._next(record.end)
        end = following.offset if following else self._source.size
        self.outline.note(record.end, end, "the index at the end of the file is damaged")
        return following.offset if following else None

    def _search(self, place: int) -> int | None:
        """Over a damaged stretch to the next record that can be believed; where it stands, None when there is none."""
        source, outline = self._source, self.outline
        chunk = chunk_at(source, place)
        if chunk is not None and readable(source, chunk, checked=True):
            outline.note(chunk.offset, chunk.body, HEAD_DAMAGED)
            self._take_chunk(Place(opcode=Opcode.CHUNK, offset=place, length=chunk.length))
            return chunk.end
        begin = self._where_it_begins(place)
        head = source.read(begin, HEAD.size)
        opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, source.size)
        following = self._record_at(begin + HEAD.size + length)
        if following is None or not self._believed(following):
            following = self._next(begin + 1)
        if following is not None:
            outline.note(begin, following.offset, damaged(opcode))
            return following.offset
        cut_off = not ends_with_magic(source) and begin + HEAD.size + length > source.size
        outline.note(
            begin,
            source.size,
            "the file was cut off in the middle of a record" if cut_off else damaged(opcode),
        )
        return None

    def _where_it_begins(self, place: int) -> int:
        """Either here, or at the chunk before, when it was its length that led here; it is no chunk then."""
        chunks = self.outline.chunks
        led_here = chunks and self._last.end == place and chunks[-1].offset == self._last.offset
        if led_here and not readable(self._source, chunks[-1], checked=self.outline.checked):
            return chunks.pop().offset
        return place

    def _believed(self, place: Place) -> bool:
        return believed(self._source, place, strict=self.outline.strict, checked=self.outline.checked)

    def _next(self, offset: int) -> Place | None:
        return next_record(self._source, offset, strict=self.outline.strict, checked=self.outline.checked)

    def _check_times(self) -> None:
        """Have a chunk's times from its messages where its head and its message indexes do not agree."""
        for number, chunk in enumerate(self.outline.chunks):
            times = self._indexed_ns.get(chunk.offset, [])
            agree = bool(times) and (min(times), max(times)) == (chunk.start_ns, chunk.end_ns)
            plain = not times and not self.outline.strict and chunk.start_ns <= chunk.end_ns
            if agree or plain:
                continue
            try:
                data, _ = contents(self._source, chunk, checked=self.outline.checked)
                start_ns, end_ns = times_in(data)
            except (DamagedRecordingError, ValueError):
                continue
            self.outline.chunks[number] = dataclasses.replace(chunk, start_ns=start_ns, end_ns=end_ns)
