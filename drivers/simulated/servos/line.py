"""What several servos that speak at once leave on a half-duplex line. Pure."""

from collections.abc import Iterable

TimedBytes = tuple[float, bytes]
"""The pause on the line in s, and what follows it."""


def overlaid(answers: Iterable[TimedBytes], byte_s: float) -> list[TimedBytes]:
    """What is heard of answers to one instruction, from servos that each believe to be alone; pauses count from the same moment.

    Who speaks while another does pulls the line low wherever either sends a 0: equal bytes at the same time pass, all
    others are spoilt. Answers that do not touch follow each other.
    """
    heard: list[TimedBytes] = []
    line_s = 0.0
    for start_s, data in sorted(answers):
        if not heard or start_s >= line_s:
            heard.append((start_s - line_s, data))
            line_s = start_s + len(data) * byte_s
            continue
        pause_s, before = heard[-1]
        begun_s = line_s - len(before) * byte_s
        both = _both_low(before, data, round((start_s - begun_s) / byte_s))
        heard[-1] = (pause_s, both)
        line_s = begun_s + len(both) * byte_s
    return heard


def _both_low(first: bytes, second: bytes, offset: int) -> bytes:
    """`second` begins `offset` bytes after `first`; an idle line is high."""
    size = max(len(first), offset + len(second))
    one, other = first.ljust(size, b"\xff"), (b"\xff" * offset + second).ljust(size, b"\xff")
    return bytes(a & b for a, b in zip(one, other, strict=True))
