"""Fills one recording, part after part, and counts what is missing between each publication and the one before."""

import logging
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from messaging.errors import CodecError
from messaging.topics import LOG
from messaging.views import LogLine
from recordings.backlog import Heard
from recordings.errors import RecordingError, UnwritableError
from recordings.losses import Losses
from recordings.part import Beginning, Summary, begin_part, write_heard
from recordings.parts import GOES_ON_IN, next_number, part_path
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

logger = logging.getLogger(__name__)

PROCESS = "record"
"""The name under which the recorder's own lines stand in the log."""


@dataclass(frozen=True, kw_only=True)
class _Open:
    """The part that is being written, and how things stood when it was begun."""

    file: RecordingWriter
    begun_ns: int
    begun_bytes: int
    lost: Mapping[str, int]
    refused: int


class Recorder:
    """One recording. Times are Unix ns and never decrease; raises as the writer does.

    A new part carries on from the one before it without a gap. Nothing here waits for the disk: parts that are finished
    may still be on their way to it, until `closed`.
    """

    def __init__(
        self,
        path: Path,
        settings: RecorderSettings,
        attachments: Mapping[str, bytes],
        newest: Collection[Heard],
        because: str,
        now_ns: int,
    ) -> None:
        """Begin, or go on with a recording that was cut off; raises RecordingInUseError, RecordingExistsError, UnwritableError."""
        self._path = path
        self._settings = settings
        self._attachments = attachments
        self._number = next_number(path)
        self._losses = Losses()
        self._refusals: Counter[str] = Counter()
        self._refused = 0
        self._lines = 0
        self._newest_ns = now_ns
        self._ended: list[Summary] = []
        self._closing: list[RecordingWriter] = []
        self._part = self._begin(newest, because)

    @property
    def path(self) -> Path:
        """The file that is being written."""
        return self._part.file.path

    @property
    def waiting_bytes(self) -> int:
        """Bytes that wait for the disk."""
        return self._part.file.waiting_bytes + sum(part.waiting_bytes for part in self._closing)

    def write(self, heard: Heard) -> None:
        """Log one publication."""
        received = heard.received
        self._losses.hear(received.key, received.epoch, received.sequence)
        self._newest_ns = heard.log_time_ns
        write_heard(self._part.file, heard, heard.log_time_ns)

    def refuse(self, error: CodecError) -> None:
        """A publication without an envelope: it cannot be logged, and is told of when the next losses are."""
        self._refused += 1
        self._refusals[str(error)] += 1

    def say(self, text: str) -> None:
        """Write a line of the recorder's own into the log."""
        line = LogLine.of(
            time_ns=self._newest_ns, level=logging.WARNING, process=PROCESS, text=f"recording: {text}"
        )
        self._part.file.write(
            LOG.key,
            LogLine.protobuf,
            line.to_bytes(),
            sequence=self._lines,
            publish_time_ns=self._newest_ns,
            log_time_ns=self._newest_ns,
        )
        self._lines += 1

    def settle(self) -> None:
        """Write what was lost into the log itself, and ask the device to keep everything up to here."""
        gaps = self._losses.settle()
        for gap in gaps:
            self.say(str(gap))
        if gaps:
            logger.warning("%d publications lost so far", sum(self._losses.lost.values()))
        for problem, count in self._refusals.items():
            self.say(f"not logged, {count} times: {problem}")
        self._refusals.clear()
        for problem in self._unfinished():
            self.say(problem)
        self._part.file.flush()

    @property
    def full(self) -> bool:
        """True when the recording shall go on in its next part."""
        size_bytes = self._part.file.size_bytes - self._part.begun_bytes
        lasted_s = (self._newest_ns - self._part.begun_ns) / 1e9
        return 0 < self._settings.rotate_bytes <= size_bytes or 0 < self._settings.rotate_s <= lasted_s

    def rotate(self, newest: Collection[Heard]) -> None:
        """Go on in the next part. Raises as the beginning does when there can be none; nothing has changed then."""
        self._number += 1
        try:
            following = self._begin(newest, "the part before it was long enough")
        except RecordingError:
            self._number -= 1
            raise
        self._end({GOES_ON_IN: following.file.path.name})
        self._part = following
        logger.info("recording goes on in %s", self.path)

    def end(self, because: str) -> Summary:
        """Finish the recording; `because` stands in its SUMMARY."""
        # a gap is settled at the second look, and nothing can come late any more
        self.settle()
        self.settle()
        self._end({"ended_because": because})
        return self._whole(self._ended)

    def give_up(self) -> int:
        """Let go of a recording that cannot be written any more; how many publications are lost with it."""
        self._part.file.give_up()
        return self._part.file.unwritten

    def closed(self, timeout_s: float = 0.0) -> bool:
        """True once everything that is finished is on the disk, or is told of in the log because it cannot be."""
        self._unfinished(timeout_s)
        return not self._closing

    def summary(self) -> Summary:
        """The whole recording so far, as far as this recorder wrote it."""
        return self._whole([*self._ended, self._summary()])

    def _begin(self, newest: Collection[Heard], because: str) -> _Open:
        beginning = Beginning(
            number=self._number,
            recording=self._path.name,
            because=because,
            attachments=self._attachments,
            newest=newest,
        )
        file = begin_part(part_path(self._path, self._number), self._settings, beginning, self._newest_ns)
        return _Open(
            file=file,
            begun_ns=self._newest_ns,
            begun_bytes=file.size_bytes,
            lost=self._losses.lost,
            refused=self._refused,
        )

    def _end(self, facts: Mapping[str, str]) -> None:
        file = self._part.file
        # a disk that fails in this moment is told of by `closed`
        with suppress(UnwritableError):
            file.describe("SUMMARY", {**self._summary().facts(), **facts})
            file.finish()
        self._ended.append(self._summary())
        self._closing.append(file)

    def _unfinished(self, timeout_s: float = 0.0) -> list[str]:
        problems = []
        for part in list(self._closing):
            try:
                if not part.closed(timeout_s):
                    continue
            except UnwritableError as error:
                problems.append(f"{error}; {part.unwritten} publications are lost")
            self._closing.remove(part)
        for problem in problems:
            logger.error("%s", problem)
        return problems

    def _summary(self) -> Summary:
        part = self._part
        return Summary(
            path=part.file.path,
            messages=dict(part.file.messages),
            lost=dict(Counter(self._losses.lost) - Counter(part.lost)),
            refused=self._refused - part.refused,
            duration_s=(self._newest_ns - part.begun_ns) / 1e9,
            size_bytes=part.file.size_bytes,
        )

    def _whole(self, parts: Sequence[Summary]) -> Summary:
        return Summary(
            path=self._path,
            messages=dict(sum((Counter(part.messages) for part in parts), Counter())),
            lost=self._losses.lost,
            refused=self._refused,
            duration_s=sum(part.duration_s for part in parts),
            size_bytes=sum(part.size_bytes for part in parts),
        )
