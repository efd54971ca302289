"""What is missing from a recording, or is not what it should be, and where."""

import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(kw_only=True)
class Damage:
    """`length` bytes from `offset` of one file that nothing could be read from, or that contradict the rest.

    `start_ns` and `end_ns` are the log times on both sides, None where nothing is known before or after. `missing` says by
    topic how many publications the sequence numbers on both sides leave out; it is filled in while messages are read.
    """

    path: Path
    offset: int
    length: int
    problem: str
    start_ns: int | None = None
    end_ns: int | None = None
    missing: Counter[str] = field(default_factory=Counter)

    def __str__(self) -> str:
        """One line: the place, the problem, and what is missing."""
        place = f"{self.path.name}, byte {self.offset}"
        if self.length:
            place += f" to {self.offset + self.length}"
        text = f"{place}: {self.problem}"
        if self.start_ns is not None and self.end_ns is not None:
            lasted_s = (self.end_ns - self.start_ns) / 1e9
            text += f"; between {_clock(self.start_ns)} and {_clock(self.end_ns)} UTC ({lasted_s:.3f} s)"
        elif self.start_ns is not None:
            text += f"; after {_clock(self.start_ns)} UTC"
        elif self.end_ns is not None:
            text += f"; before {_clock(self.end_ns)} UTC"
        if self.missing:
            topics = ", ".join(f"{count} of {key}" for key, count in sorted(self.missing.items()))
            text += f"; missing by their numbers: {topics}"
        return text


def _clock(time_ns: int) -> str:
    seconds, rest_ns = divmod(time_ns, 10**9)
    return f"{time.strftime('%H:%M:%S', time.gmtime(seconds))}.{rest_ns // 10**6:03d}"
