"""A recording as its user sees it: all its parts as one, in order of time, read as it is needed."""

import os
from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from messaging.topics import Topic
from recordings.damage import Damage
from recordings.errors import DamagedRecordingError, UnreadableError
from recordings.file_reader import Entry, FileReader, Wanted, of_topics, recorded
from recordings.metadata import CHECKSUM
from recordings.parts import absent_parts, parts
from recordings.reader import Recorded

if TYPE_CHECKING:
    import pyarrow as pa


class Log:
    """The recording at this path with the parts that follow it; a path that names a later part is that part alone.

    Raises UnreadableError when there is no such file, which every method does too, and DamagedRecordingError for a file that
    is no recording at all. Damage is no error: what can be read is handed out, and `damage` says what cannot. Times are log
    times, Unix ns.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.parts = parts(self.path)
        if not self.parts:
            raise UnreadableError(self.path, "there is no such recording")
        self.files: list[FileReader] = []
        self._hopeless: list[Damage] = []
        for part in self.parts:
            self._open(part)

    @property
    def damage(self) -> list[Damage]:
        """What has turned out to be missing so far, by part and place; complete once all messages were read."""
        absent = [
            Damage(path=path, offset=0, length=0, problem="this part of the recording is not there")
            for path in absent_parts(self.path)
        ]
        return absent + self._hopeless + [damage for file in self.files for damage in file.damage]

    def _open(self, part: Path) -> None:
        """Take up a part, or note that nothing of it can be read: that keeps nobody from the other parts."""
        file = FileReader(part)
        try:
            file.metadata()
        except DamagedRecordingError as error:
            if len(self.parts) == 1:
                raise
            length = part.stat().st_size
            self._hopeless.append(Damage(path=part, offset=0, length=length, problem=error.problem))
            return
        self.files.append(file)

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The first and the last log time; None without messages. Nothing but chunks' heads is read."""
        spans = [span for file in self.files if (span := file.span_ns)]
        return (min(start for start, _ in spans), max(end for _, end in spans)) if spans else None

    def messages(
        self, topics: Collection[Topic] | None = None, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[Recorded]:
        """Every publication of these topics (None: of all) logged from `start_ns` on and before `end_ns`.

        Lazy and in order of log time; what lies outside the times is not read. Parts follow one another as they were written.
        What a part repeats of the one before it, so as to stand for itself, is handed out once.
        """
        for path, entry in self.entries(of_topics(topics), start_ns, end_ns):
            yield recorded(path, entry)

    def entries(
        self,
        wanted: Wanted | None = None,
        start_ns: int | None = None,
        end_ns: int | None = None,
    ) -> Iterator[tuple[Path, Entry]]:
        """The same by the file's own description of its streams, with the part that holds each."""
        newest: dict[str, tuple[int, int]] = {}
        for file in self.files:
            repeats_ns = file.span_ns[0] if newest and file.span_ns else None
            for entry in file.entries(wanted, start_ns, end_ns):
                said = entry.publish_time_ns, entry.sequence
                again = newest.get(entry.stream.topic) == said or entry.publish_time_ns < (start_ns or 0)
                if not (again and entry.log_time_ns == repeats_ns):
                    newest[entry.stream.topic] = said
                    yield file.path, entry

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        """The attached files by name, of the first part that holds any: bench file and calibration."""
        return next((found for file in self.files if (found := file.attachments())), {})

    def metadata(self, name: str) -> dict[Path, dict[str, str]]:
        """The facts of this name (VERSIONS, PART, SUMMARY) in each part; a part that holds none is left out."""
        notes = {file.path: file.metadata().get(name) for file in self.files}
        return {
            path: {key: fact for key, fact in note.items() if key != CHECKSUM}
            for path, note in notes.items()
            if note is not None
        }

    def arrays(
        self, topic: Topic, *fields: str, select: Callable[[Any], bool] | None = None
    ) -> dict[str, NDArray[Any]]:
        """Fields of this topic's messages stacked over time; see recordings.arrays, which says what it raises."""
        from recordings.arrays import arrays_of  # noqa: PLC0415  readers of messages need no arrays

        return arrays_of(self.path, topic, fields, self.messages([topic]), select)

    def table(self, topic: Topic) -> "pa.Table":
        """This topic's messages as a pyarrow.Table (extra `export`), one row each; see recordings.table."""
        from recordings.table import table_of  # noqa: PLC0415  part of an extra

        return table_of(topic, self.messages([topic]))
