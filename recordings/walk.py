"""Walks through a recording's file from record to record, over damaged stretches too.

A record is passed over by its length. When what follows can be no record, either that length was wrong or bytes were
changed, lost or added: then the next record is searched for that can be believed.
"""

import dataclasses
import struct

from mcap.opcode import Opcode

from recordings.errors import DamagedRecordingError
from recordings.outline import NOT_AT_THE_BEGINNING, Outline, damaged, is_strict
from recordings.records import INDEX_HEAD, Place, header_of, is_whole, parsed, record_at, summary_of
from recordings.search import next_record, readable
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
        self._heads: dict[bytes, StoredChunk] = {}
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
        self._last = record
        chunk = chunk_at(source, record.offset) if record.opcode == Opcode.CHUNK else None
        if chunk is not None:
            return self._take_chunk(chunk)
        match record.opcode:
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
        return record.end

    def _take_chunk(self, chunk: StoredChunk) -> int | None:
        """Put the chunk where it belongs, unless it is a copy; where the next record should be."""
        outline, source = self.outline, self._source
        outline.checked |= any(source.read(chunk.offset + CRC_AT, LENGTH32.size))
        head = self._head(chunk)
        twin = self._heads.get(head) if outline.checked else None
        if twin is not None:
            if not readable(source, chunk, checked=True):
                return self._over(chunk.offset)
            if readable(source, twin, checked=True):
                outline.note(chunk.offset, chunk.end, "a chunk that stands in the file twice")
                return chunk.end
            outline.note(twin.offset, twin.end, damaged(Opcode.CHUNK))
            outline.chunks.remove(twin)
        self._heads[head] = chunk
        outline.chunks.append(chunk)
        return chunk.end

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
        whole = ends_with_magic(self._source)
        problem = (
            "the index at the end of the file is damaged" if whole else "the file was cut off in its index"
        )
        self.outline.note(record.end, end, problem)
        return following.offset if following else None

    def _search(self, place: int) -> int | None:
        """From where no record can be to the next that can be believed; where it stands, None when there is none."""
        chunk = chunk_at(self._source, place)
        if chunk is not None and readable(self._source, chunk, checked=True):
            self.outline.note(chunk.offset, chunk.body, HEAD_DAMAGED)
            return self._take_chunk(chunk)
        begin = self._where_it_begins(place)
        cut_off = self._claimed(place).end > self._source.size and not ends_with_magic(self._source)
        if not cut_off or self._next(begin + 1):
            return self._over(begin)
        if self._claimed(begin).opcode == Opcode.CHUNK and begin < place:
            self.outline.note(begin, place, damaged(Opcode.CHUNK))
        self.outline.note(place, self._source.size, "the file was cut off in the middle of a record")
        return None

    def _over(self, begin: int) -> int | None:
        """Over a damaged stretch that begins here."""
        record = self._claimed(begin)
        following = self._next(record.end if is_whole(self._source, record) else begin + 1)
        end = following.offset if following else self._source.size
        self.outline.note(begin, end, damaged(record.opcode))
        return following.offset if following else None

    def _claimed(self, place: int) -> Place:
        """The record that the bytes here claim to be."""
        head = self._source.read(place, HEAD.size)
        opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, self._source.size)
        return Place(opcode=opcode, offset=place, length=HEAD.size + length)

    def _where_it_begins(self, place: int) -> int:
        """Either here, or at the record before, when it is its length that cannot be believed."""
        last, chunks = self._last, self.outline.chunks
        if last.end != place:
            return place
        if last.opcode == Opcode.MESSAGE_INDEX:
            return last.offset
        led_here = bool(chunks) and chunks[-1].offset == last.offset
        if led_here and not readable(self._source, chunks[-1], checked=self.outline.checked):
            del self._heads[self._head(chunks[-1])]
            return chunks.pop().offset
        return place

    def _head(self, chunk: StoredChunk) -> bytes:
        """What no two chunks have in common. Opcode and length are left out: they may be damaged where the rest is not."""
        begin = chunk.offset + HEAD.size
        return self._source.read(begin, chunk.body - begin)

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
