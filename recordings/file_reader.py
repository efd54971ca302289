"""Reads one file of a recording, as far as it goes. Nothing in it is believed that contradicts its checksum."""

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from messaging.topics import Topic
from recordings.continuity import Continuity, Numbers
from recordings.damage import Damage
from recordings.errors import DamagedRecordingError
from recordings.outline import Outline, attached, indexed
from recordings.reader import Recorded, names
from recordings.records import record_of
from recordings.source import Source
from recordings.stored_chunk import HEAD, HEAD_DAMAGED, MESSAGE, StoredChunk, contents, records_in, times_in
from recordings.streams import Stream, Streams
from recordings.walk import walked

_log_time = itemgetter(1)


class Entry(NamedTuple):
    """A message as it stands in a file. Times are Unix ns."""

    stream: Stream
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    payload: bytes


Wanted = Callable[[Stream], bool]


class FileReader:
    """One file. Every method raises UnreadableError, and DamagedRecordingError when nothing of an MCAP file is in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._known: Outline | None = None

    @property
    def damage(self) -> list[Damage]:
        """What has turned out to be missing so far, by place; complete once everything was read."""
        return [] if self._known is None else self._known.damage

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The first and the last log time, as the chunks' heads say; None without messages."""
        with Source(self.path) as source:
            chunks = self._outline(source).chunks
        return (chunks[0].start_ns, max(chunk.end_ns for chunk in chunks)) if chunks else None

    @property
    def compression(self) -> str:
        """MCAP's name of how its first chunk is stored; empty when it is not compressed."""
        with Source(self.path) as source:
            chunks = self._outline(source).chunks
        return chunks[0].compression if chunks else ""

    def entries(
        self,
        wanted: Wanted | None = None,
        start_ns: int | None = None,
        end_ns: int | None = None,
    ) -> Iterator[Entry]:
        """The messages of the wanted streams logged from `start_ns` on and before `end_ns`, by log time."""
        with Source(self.path) as source:

            def look_again() -> Outline:
                self._known = walked(source)
                return self._known

            yield from _Reading(source, self._outline(source), wanted, look_again).entries(start_ns, end_ns)

    def messages(
        self, topics: Collection[Topic] | None = None, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[Recorded]:
        """The publications of these topics (None: of all) in the same way."""
        for entry in self.entries(of_topics(topics), start_ns, end_ns):
            yield recorded(self.path, entry)

    def attachments(self) -> dict[str, bytes]:
        """The attached files by name."""
        with Source(self.path) as source:
            outline = self._outline(source)
            found = attached(outline, source, outline.attachments)
        return {record.name: record.data for record in found if isinstance(record, Attachment)}

    def metadata(self) -> dict[str, dict[str, str]]:
        """The metadata records by name, as they stand there."""
        with Source(self.path) as source:
            outline = self._outline(source)
            found = attached(outline, source, outline.metadata)
        return {record.name: record.metadata for record in found if isinstance(record, Metadata)}

    def _outline(self, source: Source) -> Outline:
        if self._known is None:
            self._known = indexed(source) or walked(source)
        return self._known


def of_topics(topics: Collection[Topic] | None) -> Wanted | None:
    """What the streams of these topics have in common; None for all."""
    return None if topics is None else lambda stream: any(names(topic, stream.topic) for topic in topics)


def recorded(path: Path, entry: Entry) -> Recorded:
    """The publication in this entry."""
    return Recorded(
        path=path,
        topic=entry.stream.topic,
        schema=entry.stream.schema,
        log_time_ns=entry.log_time_ns,
        publish_time_ns=entry.publish_time_ns,
        sequence=entry.sequence,
        payload=entry.payload,
    )


class _Reading:
    """One pass through a file; holds the contents of one chunk at a time, of more only where they overlap in time."""

    def __init__(
        self, source: Source, outline: Outline, wanted: Wanted | None, look_again: Callable[[], Outline]
    ) -> None:
        self._source = source
        self._look_again = look_again
        self._outline = outline
        self._wanted = wanted
        self._streams = Streams([*outline.schemas, *outline.channels])
        self._continuity = Continuity(self._streams)
        self._swept = False

    def entries(self, start_ns: int | None, end_ns: int | None) -> Iterator[Entry]:
        waiting: list[Entry] = []
        done: set[int] = set()
        passed = 0
        chunks = deque(self._outline.chunks)
        while chunks:
            chunk = chunks.popleft()
            if end_ns is not None and chunk.start_ns >= end_ns:
                break
            if start_ns is None or chunk.end_ns >= start_ns:
                due = bisect_right(waiting, chunk.start_ns, key=_log_time)
                yield from waiting[:due]
                del waiting[:due]
                data = self._contents(chunk)
                if data is None:
                    if self._outline.indexed:
                        # what the index points at is not there: the file itself has to tell
                        self._outline = self._look_again()
                        chunks = deque(chunk for chunk in self._outline.chunks if chunk.offset not in done)
                    continue
                for damage in self._outline.damage:
                    if passed <= damage.offset < chunk.offset:
                        self._continuity.breaks(damage)
                waiting = sorted(waiting + self._messages(chunk, data, start_ns, end_ns), key=_log_time)
            done.add(chunk.offset)
            passed = chunk.offset
        yield from waiting

    def _contents(self, chunk: StoredChunk) -> memoryview | None:
        """What is in the chunk; None, and a damage more, when it is not what it should be."""
        try:
            data, sound = contents(self._source, chunk, checked=self._outline.checked)
        except DamagedRecordingError as error:
            self._outline.note(chunk.offset, chunk.end, error.problem)
            return None
        with suppress(ValueError):
            if not sound and times_in(data) != (chunk.start_ns, chunk.end_ns):
                self._outline.note(chunk.offset, chunk.end, "another chunk than the index names")
                return None
        if not sound:
            self._outline.note(chunk.offset, chunk.body, HEAD_DAMAGED)
        return data

    def _messages(
        self, chunk: StoredChunk, data: memoryview, start_ns: int | None, end_ns: int | None
    ) -> list[Entry]:
        """The wanted messages in a chunk's contents."""
        messages: list[Entry] = []
        numbers = Numbers()
        streams: dict[int, Stream | None] = {}
        try:
            for opcode, begin, end in records_in(data):
                if opcode != Opcode.MESSAGE:
                    self._describe(opcode, data[begin:end])
                    streams.clear()
                    continue
                channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(data, begin + HEAD.size)
                numbers.first.setdefault(channel, sequence)
                numbers.last[channel] = sequence
                if channel not in streams:
                    streams[channel] = self._wanted_stream(channel)
                stream = streams[channel]
                if stream is None or (start_ns or log_ns) > log_ns or (end_ns or log_ns + 1) <= log_ns:
                    continue
                payload = data[begin + HEAD.size + MESSAGE.size : end].tobytes()
                messages.append(Entry(stream, log_ns, publish_ns, sequence, payload))
        except ValueError as error:
            self._outline.note(chunk.offset, chunk.end, f"a chunk that was written wrongly: {error}")
        self._continuity.hear(numbers)
        for channel in numbers.last:
            if self._streams.of(channel) is None:
                self._outline.note(
                    chunk.offset, chunk.end, f"messages of channel {channel}, which is described nowhere"
                )
        return messages

    def _describe(self, opcode: int, data: memoryview) -> None:
        if opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
            record = record_of(data.tobytes(), strict=False)
            if record is not None:
                self._streams.take(record)

    def _wanted_stream(self, channel: int) -> Stream | None:
        """The stream of this channel; None when it is unwanted, or described nowhere in the file."""
        if self._streams.of(channel) is None and not self._swept:
            self._swept = True
            self._sweep()
        stream = self._streams.of(channel)
        return stream if stream is not None and (self._wanted is None or self._wanted(stream)) else None

    def _sweep(self) -> None:
        """Look for descriptions in the whole file: those that should stand before this place were lost, or were passed over."""
        for chunk in self._outline.chunks:
            with suppress(DamagedRecordingError, ValueError):
                data, _ = contents(self._source, chunk, checked=self._outline.checked)
                for opcode, begin, end in records_in(data):
                    if opcode != Opcode.MESSAGE:
                        self._describe(opcode, data[begin:end])
