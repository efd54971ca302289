"""What is missing from a recording, or is not what it should be, and where."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(kw_only=True)
class Damage:
    """`length` bytes from `offset` of one file that nothing could be read from, or that contradict the rest.

    `missing` says by topic how many publications the sequence numbers on both sides of the place leave out; it is filled in
    while messages are read. `start_ns` and `end_ns` are the log times on both sides, None where the file begins or ends.
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
        text = f"{self.path.name}: byte {self.offset}: {self.problem}"
        if self.missing:
            text += ": missing " + ", ".join(
                f"{count} of {key}" for key, count in sorted(self.missing.items())
            )
        return text
