"""Writes recorded messages into a new, whole file: their bytes, times, numbers and descriptions as they are."""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from recordings.file_reader import Entry
from recordings.mcap_file import McapFile
from recordings.metadata import sealed
from recordings.output import Output
from recordings.streams import Stream
from recordings.writer import PACKINGS, media_type

CHUNK_BYTES = 2**20


class Copy:
    """A new recording made of others; used in a `with` statement, which finishes it unless something went wrong.

    It is compressed when they are. Raises RecordingExistsError when the file exists, and DiskFullError or UnwritableError at any time.
    """

    def __init__(self, path: Path, *, compressed: bool) -> None:
        self.messages: Counter[str] = Counter()
        self.span_ns: tuple[int, int] | None = None
        self._output = Output(path)
        self._file = McapFile(self._output, CHUNK_BYTES, PACKINGS["lz4" if compressed else "none"])
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[Stream, int] = {}

    def attach(self, files: Mapping[str, bytes], time_ns: int) -> None:
        """Put these files into it."""
        for name, data in files.items():
            self._file.attachment(name, media_type(name), data, time_ns)

    def describe(self, name: str, facts: Mapping[str, str]) -> None:
        """Add a metadata record, with its checksum."""
        self._file.metadata(name, sealed(facts))

    def write(self, entries: Iterable[Entry], log_time_ns: int | None = None) -> None:
        """Append messages, at their own log times or all at this one."""
        for stream, own_ns, publish_ns, sequence, payload in entries:
            time_ns = own_ns if log_time_ns is None else log_time_ns
            channel = self._channels.get(stream) or self._channel(stream)
            self._file.message(channel, sequence, time_ns, publish_ns, payload)
            self.messages[stream.topic] += 1
            begin_ns, end_ns = self.span_ns or (time_ns, time_ns)
            self.span_ns = min(begin_ns, time_ns), max(end_ns, time_ns)

    def summarise(self, lost: Mapping[str, int], because: str) -> None:
        """Add the SUMMARY of what was written: `lost` as recorders counted it, and why it ends here."""
        begin_ns, end_ns = self.span_ns or (0, 0)
        self.describe(
            "SUMMARY",
            {
                **{f"messages/{key}": str(count) for key, count in self.messages.items()},
                **{f"lost/{key}": str(count) for key, count in lost.items()},
                "duration_s": f"{(end_ns - begin_ns) / 1e9:.3f}",
                "ended_because": because,
            },
        )

    def __enter__(self) -> Self:
        """The file, ready to be written."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish it, unless something went wrong."""
        with self._output:
            if error is None:
                self._file.finish()
                self._output.sync()

    def _channel(self, stream: Stream) -> int:
        described = (stream.schema, stream.schema_encoding, stream.schema_data)
        if any(described) and described not in self._schemas:
            self._schemas[described] = self._file.schema(*described)
        self._channels[stream] = self._file.channel(
            stream.topic, stream.encoding, self._schemas.get(described, 0), stream.metadata
        )
        return self._channels[stream]
