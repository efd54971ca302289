"""Which of the pictures that a camera streams are good, and what is wrong with the others. Pure."""

from collections import Counter
from enum import StrEnum

from drivers.cameras.v4l2.stream import Captured

START_OF_IMAGE, END_OF_IMAGE = b"\xff\xd8", b"\xff\xd9"
PADDING = b"\0"
SEQUENCE_NUMBERS = 2**32
REPORT_S = 60.0


class PictureFault(StrEnum):
    """Why a picture is not handed on."""

    LOST = "lost on the way"
    DAMAGED = "marked as damaged by the driver"
    INCOMPLETE = "no complete JPEG"
    REPEATED = "the same as the one before"
    OLDER = "not later than the one before"


class Inspection:
    """Looks at every picture of one camera, over all its streams.

    `faults` counts what was not handed on, and why; `since_good` is why those since the last good one were not.
    """

    def __init__(self) -> None:
        self.faults: Counter[PictureFault] = Counter()
        self.since_good: set[PictureFault] = set()
        self._number = -1
        self.begin()

    def begin(self) -> None:
        """A new stream: its sequence, and its times, may begin anew."""
        self._sequence: int | None = None
        self._newest_ns = 0
        self._jpeg = b""
        self.since_good.clear()

    def number_of(self, captured: Captured) -> int | None:
        """The picture's number among all of this camera's, lost ones included; None if it is not good."""
        self._count(captured.sequence)
        fault = self._fault(captured)
        if fault is not None:
            self.faults[fault] += 1
            self.since_good.add(fault)
            return None
        self.since_good.clear()
        self._newest_ns, self._jpeg = captured.capture_monotonic_ns, captured.jpeg
        return self._number

    def _count(self, sequence: int) -> None:
        steps = 1 if self._sequence is None else (sequence - self._sequence) % SEQUENCE_NUMBERS
        if not 0 < steps < SEQUENCE_NUMBERS // 2:
            # a driver that does not count, or began anew
            steps = 1
        self._sequence = sequence
        self._number += steps
        if steps > 1:
            self.faults[PictureFault.LOST] += steps - 1

    def _fault(self, captured: Captured) -> PictureFault | None:
        if captured.is_damaged:
            return PictureFault.DAMAGED
        if not is_complete_jpeg(captured.jpeg):
            return PictureFault.INCOMPLETE
        if captured.jpeg == self._jpeg:
            return PictureFault.REPEATED
        if captured.capture_monotonic_ns <= self._newest_ns:
            return PictureFault.OLDER
        return None


class FaultReport:
    """Says at most once in REPORT_S what has been counted since it was said last."""

    def __init__(self, faults: Counter[PictureFault]) -> None:
        self._faults = faults
        self._said = faults.copy()
        self._due_s = float("-inf")

    def due(self, now_s: float) -> str | None:
        """The text, when it is time and there is something to say."""
        since = self._faults - self._said
        if now_s < self._due_s or not since:
            return None
        self._due_s = now_s + REPORT_S
        self._said = self._faults.copy()
        return "pictures left out: " + ", ".join(f"{count} {fault}" for fault, count in since.items())


def is_complete_jpeg(jpeg: bytes) -> bool:
    """Whether a picture begins and ends as it must; some cameras fill up with zeros behind it.

    Within the coded picture an end marker cannot occur by chance: 0xFF is followed by 0 there (ISO 10918-1, B.1.1.5).
    """
    end = jpeg.rfind(END_OF_IMAGE)
    return jpeg.startswith(START_OF_IMAGE) and end > 0 and not jpeg[end + len(END_OF_IMAGE) :].strip(PADDING)
