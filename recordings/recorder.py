"""What the recorder does with each publication: write it, and count what is missing between it and the one before."""

import logging
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from messaging.errors import CodecError
from messaging.session import Received
from messaging.topics import LOG, Topic
from messaging.views import LogLine
from recordings.losses import Losses
from recordings.writer import RecordingWriter

logger = logging.getLogger(__name__)

PROCESS = "record"
"""The name under which the recorder's own lines stand in the log."""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What a recording holds: publications and losses by topic, its length in time and in bytes."""

    path: Path
    messages: Mapping[str, int]
    lost: Mapping[str, int]
    duration_s: float
    size_bytes: int

    def facts(self) -> dict[str, str]:
        """The same in words, for the recording's metadata."""
        return {
            **{f"messages/{key}": str(count) for key, count in self.messages.items()},
            **{f"lost/{key}": str(count) for key, count in self.lost.items()},
            "duration_s": f"{self.duration_s:.3f}",
        }


class Recorder:
    """Fills one recording. Times are Unix ns and never decrease; raises as the writer does."""

    def __init__(self, recording: RecordingWriter, start_ns: int) -> None:
        self._recording = recording
        self._start_ns = start_ns
        self._losses = Losses()
        self._refused: Counter[str] = Counter()
        self._lines = 0

    def hear(self, topic: Topic, received: Received, now_ns: int) -> None:
        """Log one publication as it came."""
        self._losses.hear(received.key, received.epoch, received.sequence)
        self._recording.write(
            received.key,
            topic.type.protobuf,
            received.payload,
            sequence=received.sequence,
            publish_time_ns=received.publish_time_ns,
            log_time_ns=now_ns,
        )

    def refuse(self, error: CodecError) -> None:
        """A publication without an envelope: it cannot be logged, and is told of when the next losses are."""
        self._refused[str(error)] += 1

    def settle(self, now_ns: int) -> None:
        """Write what was lost into the log itself, and have the device keep everything up to here."""
        gaps = self._losses.settle()
        for gap in gaps:
            self._say(f"recording: {gap}", now_ns)
        if gaps:
            logger.warning("%d publications lost so far", sum(self._losses.lost.values()))
        for problem, count in self._refused.items():
            self._say(f"recording: not logged, {count} times: {problem}", now_ns)
        self._refused.clear()
        self._recording.flush()

    def end(self, now_ns: int) -> None:
        """Settle what is still open and add the summary."""
        # a gap is settled at the second look, and nothing can come late any more
        self.settle(now_ns)
        self.settle(now_ns)
        self._recording.describe("SUMMARY", self.summary(now_ns).facts())

    def summary(self, now_ns: int) -> Summary:
        """The recording so far."""
        return Summary(
            path=self._recording.path,
            messages=dict(self._recording.messages),
            lost=self._losses.lost,
            duration_s=(now_ns - self._start_ns) / 1e9,
            size_bytes=self._recording.size_bytes,
        )

    def _say(self, text: str, now_ns: int) -> None:
        line = LogLine.of(time_ns=now_ns, level=logging.WARNING, process=PROCESS, text=text)
        self._recording.write(
            LOG.key,
            LogLine.protobuf,
            line.to_bytes(),
            sequence=self._lines,
            publish_time_ns=now_ns,
            log_time_ns=now_ns,
        )
        self._lines += 1
