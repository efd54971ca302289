"""When a topic was said: rates, silences, numbers left out. Pure, on times of all its publications."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

PAUSE_PERIODS, PAUSE_S = 10, 1.0
"""So long a silence is a pause, which says nothing about the rate: so many expected periods; seconds where none is expected."""
RENUMBERED = 2**31
CLOCK_STEP_NS = 1_000_000


@dataclass
class Heard:
    """One topic's publications in order: their log and publish times (Unix ns), sequence numbers, and bytes in all."""

    schema: str
    size_bytes: int = 0
    log_ns: "array[int]" = field(default_factory=lambda: array("q"))
    publish_ns: "array[int]" = field(default_factory=lambda: array("q"))
    sequence: "array[int]" = field(default_factory=lambda: array("q"))

    def hear(self, log_ns: int, publish_ns: int, sequence: int, size_bytes: int) -> None:
        """One more."""
        self.log_ns.append(log_ns)
        self.publish_ns.append(publish_ns)
        self.sequence.append(sequence)
        self.size_bytes += size_bytes


@dataclass(frozen=True)
class Silence:
    """From one publication to the next, Unix ns."""

    begin_ns: int
    end_ns: int

    @property
    def lasted_s(self) -> float:
        """How long."""
        return (self.end_ns - self.begin_ns) / 1e9


class Traffic:
    """What follows from the times. `expected_hz` is None for topics that are said now and then."""

    def __init__(self, heard: Heard, expected_hz: float | None) -> None:
        self.heard = heard
        self.expected_hz = expected_hz
        self.count = len(heard.log_ns)
        self._log_ns = np.array(heard.log_ns, np.int64)
        self._publish_ns = np.array(heard.publish_ns, np.int64)
        self._gaps_s = np.diff(self._publish_ns) / 1e9

    @cached_property
    def rate_hz(self) -> float | None:
        """While it was being said: pauses are left out. None when that cannot be told."""
        pause_s = PAUSE_PERIODS / self.expected_hz if self.expected_hz else PAUSE_S
        gaps_s = self._gaps_s[(self._gaps_s >= 0) & (self._gaps_s < pause_s)]
        return len(gaps_s) / float(gaps_s.sum()) if gaps_s.sum() > 0 else None

    @cached_property
    def largest_gap_s(self) -> float | None:
        """Between one publication and the next; None for fewer than two."""
        return float(self._gaps_s.max()) if self._gaps_s.size else None

    def silences(self, longer_than_s: float) -> list[Silence]:
        """In order of time."""
        return [
            Silence(int(self._publish_ns[index]), int(self._publish_ns[index + 1]))
            for index in np.flatnonzero(self._gaps_s > longer_than_s)
        ]

    @cached_property
    def missing(self) -> int:
        """Numbers left out; those that fall back begin a new life of the publisher."""
        steps = np.diff(np.array(self.heard.sequence, np.int64))
        return int((steps[(steps > 1) & (steps < RENUMBERED)] - 1).sum())

    @cached_property
    def restarts(self) -> list[Silence]:
        """Where its numbers fall back, because its only publisher began anew."""
        steps = np.diff(np.array(self.heard.sequence, np.int64))
        return [
            Silence(int(self._publish_ns[index]), int(self._publish_ns[index + 1]))
            for index in np.flatnonzero((steps < 0) & (steps > -RENUMBERED))
        ]

    @cached_property
    def set_back(self) -> list[Silence]:
        """Where the publisher's clock was set back: publish times decrease by more than a millisecond."""
        return [
            Silence(int(self._publish_ns[index]), int(self._publish_ns[index + 1]))
            for index in np.flatnonzero(np.diff(self._publish_ns) < -CLOCK_STEP_NS)
        ]

    @cached_property
    def numbers(self) -> set[tuple[int, int]]:
        """The life of its publisher and the sequence number of each publication."""
        numbers = np.array(self.heard.sequence, np.int64)
        lives = np.concatenate([[0], np.cumsum(np.diff(numbers) < 0)]) if len(numbers) else numbers
        return set(zip(lives.tolist(), numbers.tolist(), strict=True))


def without_partner(cameras: Sequence[Traffic]) -> int:
    """How many frames belong to a set that not every camera has a frame of."""
    if len(cameras) < 2:
        return 0
    whole = set.intersection(*(camera.numbers for camera in cameras))
    return sum(len(camera.numbers) - len(whole) for camera in cameras)
