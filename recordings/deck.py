"""What the recorder can be asked to do, as with a tape deck: start, stop, save the last seconds, say how it stands."""

import logging
from collections.abc import Mapping
from pathlib import Path

from messaging.errors import CodecError
from recordings.backlog import Backlog
from recordings.errors import DeletedError, DiskFullError, RecordingError, UnwritableError
from recordings.output import free_bytes, make_folder_of
from recordings.part import Summary
from recordings.parts import new_path
from recordings.recorder import Recorder
from recordings.settings import RecorderSettings

logger = logging.getLogger(__name__)

WRITE_AHEAD_BYTES = 16 * 2**20
"""What may wait for the disk in the file's own queue; the rest waits in the backlog, whose size is bounded."""
STEP_BYTES = 8 * 2**20
"""What is written before hearing has its turn again."""
FOR_EVER_NS = 2**63


class Deck:
    """Fills recordings from a backlog that its owner fills. Times are Unix ns.

    It is waiting, recording, or saving: a recording that begins with what the backlog held, and ends by itself. One that
    cannot be written any more is told of in the log, and the deck waits again. Nothing is tried without being asked for,
    but when the file was deleted: then the recording goes on in a new one.
    """

    def __init__(
        self, settings: RecorderSettings, attachments: Mapping[str, bytes], backlog: Backlog
    ) -> None:
        self._settings = settings
        self._attachments = attachments
        self._backlog = backlog
        self._recorder: Recorder | None = None
        self._path = Path()
        self._until_ns = FOR_EVER_NS
        self._settle_at_ns = 0
        self._dropped = 0
        self._told = ""
        self._closing: list[Recorder] = []
        self._waits_because = "nothing was asked for yet"
        self.last: Summary | None = None

    @property
    def state(self) -> str:
        """`waiting`, `recording` or `saving`."""
        if self._recorder is None:
            return "waiting"
        return "recording" if self._until_ns == FOR_EVER_NS else "saving"

    def start(self, path: Path | None, now_ns: int, because: str) -> None:
        """Begin a recording, after a save that is going on; raises RecordingError."""
        self.stop("a recording was asked for")
        self._backlog.forget(now_ns)
        self._begin(path or new_path(Path(self._settings.folder), now_ns), now_ns, because)

    def save(self, path: Path | None, now_ns: int, because: str, purpose: str) -> None:
        """Save what the backlog holds and what follows soon, or lengthen the save that is going on; raises RecordingError."""
        if self._recorder is None:
            self._begin(path or new_path(Path(self._settings.folder), now_ns, purpose), now_ns, because)
        self._until_ns = now_ns + int(self._settings.rolling_follow_s * 1e9)

    def stop(self, because: str) -> None:
        """Finish what is being recorded, with all that was heard so far."""
        if self._recorder is None:
            return
        try:
            self._write(self._recorder, self._backlog.size_bytes)
            self._end(self._recorder, because)
        except UnwritableError as error:
            self._give_up(self._recorder, error)

    def step(self, now_ns: int) -> bool:
        """Write what is due, and keep the file and the disk in order; True when there is more to write at once."""
        self._closing = [recorder for recorder in self._closing if not recorder.closed()]
        if (recorder := self._recorder) is None:
            self._backlog.forget(now_ns - int(self._settings.rolling_s * 1e9))
            return False
        try:
            return self._record(recorder, now_ns)
        except DeletedError as error:
            self._give_up(recorder, error)
            self._go_on(error, now_ns)
        except UnwritableError as error:
            self._give_up(recorder, error)
        return False

    def refuse(self, error: CodecError) -> None:
        """A publication that cannot be logged."""
        if self._recorder is not None:
            self._recorder.refuse(error)

    def closed(self, timeout_s: float) -> bool:
        """True once everything that was ended is on the disk."""
        return all(recorder.closed(timeout_s) for recorder in self._closing)

    def describe(self) -> str:
        """How things stand, in words."""
        if self._recorder is None:
            kept = f"; {in_words(self._backlog.size_bytes)} kept in memory" * (self._settings.rolling_s > 0)
            free = free_bytes(Path(self._settings.folder, "any"))
            return f"{self._waits_because}{kept}; {in_words(free)} free"
        waiting = self._recorder.waiting_bytes + self._backlog.size_bytes
        return (
            f"{self._recorder.path}: {account(self._recorder.summary())}, "
            f"{in_words(waiting)} on the way; {in_words(free_bytes(self._recorder.path))} free"
        )

    def _begin(self, path: Path, now_ns: int, because: str) -> None:
        if problem := self._no_room(path):
            self._waits_because = f"no recording was begun: {problem}"
            raise DiskFullError(path, problem)
        self._recorder = Recorder(
            path,
            self._settings,
            self._attachments,
            list(self._backlog.newest.values()),
            because,
            self._backlog.first_ns or now_ns,
        )
        self._path, self._until_ns, self._settle_at_ns = path, FOR_EVER_NS, now_ns
        self._dropped, self._told = self._backlog.dropped, ""
        logger.info("recording to %s: %s", self._recorder.path, because)

    def _record(self, recorder: Recorder, now_ns: int) -> bool:
        """Write what is due; True when there is more."""
        self._write(recorder, min(STEP_BYTES, WRITE_AHEAD_BYTES - recorder.waiting_bytes))
        more = self._due
        if now_ns >= self._settle_at_ns:
            self._settle_at_ns = now_ns + int(self._settings.flush_period_s * 1e9)
            self._settle(recorder)
        if now_ns > self._until_ns and not more and self._recorder is not None:
            self._end(recorder, "everything that was to be saved is saved")
        return more and recorder.waiting_bytes < WRITE_AHEAD_BYTES

    def _settle(self, recorder: Recorder) -> None:
        """Keep the file and the disk in order: what was lost is told, what was written is synced, what is long enough goes on."""
        if dropped := self._backlog.dropped - self._dropped:
            self._dropped = self._backlog.dropped
            kept = in_words(self._settings.memory_bytes)
            self._tell(
                recorder, f"the disk is too slow: {kept} waited, and {dropped} publications were dropped"
            )
        recorder.settle()
        if problem := self._no_room(recorder.path):
            self._tell(recorder, problem)
            self._end(recorder, problem)
        elif recorder.full:
            self._rotate(recorder)

    @property
    def _due(self) -> bool:
        first_ns = self._backlog.first_ns
        return first_ns is not None and first_ns <= self._until_ns

    def _write(self, recorder: Recorder, size_bytes: int) -> None:
        left = size_bytes
        while left > 0 and self._due:
            heard = self._backlog.pop()
            left -= len(heard.received.payload) + 1
            recorder.write(heard)

    def _rotate(self, recorder: Recorder) -> None:
        try:
            recorder.rotate(list(self._backlog.newest.values()))
        except RecordingError as error:
            self._tell(
                recorder,
                f"it goes on in this file, though it is long enough, because there can be no next: {error}",
            )

    def _tell(self, recorder: Recorder, text: str) -> None:
        """In the recording itself and in the process's log; the same is not told again and again."""
        if text != self._told:
            self._told = text
            recorder.say(text)
            logger.warning("recording %s: %s", recorder.path, text)

    def _end(self, recorder: Recorder, because: str) -> None:
        self.last = recorder.end(because)
        self._wait(recorder, f"{recorder.path} ended ({account(self.last)}): {because}")
        logger.info("%s", self._waits_because)

    def _give_up(self, recorder: Recorder, error: UnwritableError) -> None:
        lost = recorder.give_up()
        self.last = recorder.summary()
        self._wait(recorder, f"{error}; {lost} publications are lost with it")
        logger.error("%s", self._waits_because)

    def _wait(self, recorder: Recorder, because: str) -> None:
        self._recorder, self._waits_because = None, because
        self._closing.append(recorder)

    def _go_on(self, error: DeletedError, now_ns: int) -> None:
        told, until_ns = self._waits_because, self._until_ns
        try:
            make_folder_of(self._path)
            self._begin(self._path, now_ns, str(error))
        except RecordingError as problem:
            self._waits_because = f"{told}; there can be no further file: {problem}"
            logger.warning("%s", self._waits_because)
            return
        self._until_ns = until_ns
        if self._recorder is not None:
            self._tell(self._recorder, told)

    def _no_room(self, path: Path) -> str:
        free, least = free_bytes(path), self._settings.least_free_bytes
        if free >= least:
            return ""
        return (
            f"only {in_words(free)} is left on the disk, "
            f"and recorder.least_free_bytes = {least} keeps {in_words(least)} free"
        )


def account(summary: Summary) -> str:
    """Length, size and losses in words."""
    lost = sum(summary.lost.values())
    refused = f", {summary.refused} refused" * (summary.refused > 0)
    return f"{summary.duration_s:.1f} s, {in_words(summary.size_bytes)}, {lost} publications lost{refused}"


def in_words(size_bytes: int) -> str:
    """For people."""
    return f"{size_bytes / 1e9:.2f} GB" if size_bytes >= 1e9 else f"{size_bytes / 1e6:.1f} MB"
