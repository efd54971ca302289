"""Losses, counted from sequence numbers: what a publisher numbered and the recorder never saw.

Each life of a publisher (its epoch) counts for itself, so a restart is not a loss, and neither is what was said before
the recorder listened. A publication that comes late fills its gap again, one that comes twice changes nothing.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Gap:
    """Publications `first` to `last` of one topic, both included, that never arrived."""

    key: str
    first: int
    last: int

    @property
    def count(self) -> int:
        """How many are missing."""
        return self.last - self.first + 1

    def __str__(self) -> str:
        """Both ends, for the log."""
        span = f"{self.first}" if self.count == 1 else f"{self.first} to {self.last}"
        return f"{self.key}: {self.count} lost (sequence {span})"

    def without(self, sequence: int) -> "list[Gap]":
        """What is still missing once this one has come."""
        if not self.first <= sequence <= self.last:
            return [self]
        halves = (self.first, sequence - 1), (sequence + 1, self.last)
        return [Gap(key=self.key, first=first, last=last) for first, last in halves if first <= last]


@dataclass
class _Publisher:
    next: int
    fresh: list[Gap] = field(default_factory=list)
    waiting: list[Gap] = field(default_factory=list)

    def hear(self, key: str, sequence: int) -> None:
        if sequence < self.next:
            self.fresh = [left for gap in self.fresh for left in gap.without(sequence)]
            self.waiting = [left for gap in self.waiting for left in gap.without(sequence)]
            return
        if sequence > self.next:
            self.fresh.append(Gap(key=key, first=self.next, last=sequence - 1))
        self.next = sequence + 1


class Losses:
    """Hears the sequence number of every publication, and tells which gaps stay open."""

    def __init__(self) -> None:
        self._publishers: dict[tuple[str, int], _Publisher] = {}
        self._lost: Counter[str] = Counter()

    def hear(self, key: str, epoch: int, sequence: int) -> None:
        """Take note of one publication."""
        publisher = self._publishers.get((key, epoch))
        if publisher is None:
            publisher = self._publishers[key, epoch] = _Publisher(next=sequence)
        publisher.hear(key, sequence)

    def settle(self) -> list[Gap]:
        """Gaps that were open at the call before and still are: they count as lost from now on."""
        settled = []
        for publisher in self._publishers.values():
            settled += publisher.waiting
            publisher.waiting, publisher.fresh = publisher.fresh, []
        for gap in settled:
            self._lost[gap.key] += gap.count
        return settled

    @property
    def lost(self) -> Mapping[str, int]:
        """Publications lost so far, by topic; topics that lost nothing are not named."""
        return dict(self._lost)
