"""Text as the pages of `nodal log` show it: aligned columns, times, sizes. Pure."""

import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nodal.log.deriving import Derived

UNITS = ("B", "kB", "MB", "GB")


def aligned(rows: Iterable[Sequence[str]], right: Sequence[int] = ()) -> list[str]:
    """Rows of cells as lines with columns of one width; columns of these numbers are set to the right."""
    table = [list(row) for row in rows]
    widths = [max(len(cell) for cell in column) for column in zip(*table, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if number in right else cell.ljust(width)
            for number, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in table
    ]


def size(size_bytes: int) -> str:
    """`3.2 MB`."""
    value, unit = float(size_bytes), 0
    while value >= 1000 and unit < len(UNITS) - 1:
        value, unit = value / 1000, unit + 1
    return f"{value:.1f} {UNITS[unit]}" if unit else f"{size_bytes} B"


def seconds(value: float | None) -> str:
    """`0.034 s`, `12.5 s`; a dash for nothing."""
    if value is None:
        return "-"
    return f"{value:.3f} s" if abs(value) < 10 else f"{value:.1f} s"


def hertz(value: float | None) -> str:
    """`29.9 Hz`; a dash for nothing."""
    return "-" if value is None else f"{value:.4g} Hz" if value < 10 else f"{value:.1f} Hz"


def utc(time_ns: int) -> str:
    """`2026-05-02 13:04:05.250 UTC`."""
    whole, rest_ns = divmod(time_ns, 10**9)
    return f"{time.strftime('%Y-%m-%d %H:%M:%S', time.gmtime(whole))}.{rest_ns // 10**6:03d} UTC"


def counted(count: int, noun: str) -> str:
    """`1 message`, `2 messages`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def derived_in_words(derived: "Derived") -> str:
    """What a new recording holds."""
    begin_ns, end_ns = derived.span_ns
    repeated = f", the first {derived.repeated} repeated from before" if derived.repeated else ""
    return (
        f"{derived.path}: {counted(derived.messages.total(), 'message')} of {counted(len(derived.messages), 'topic')} "
        f"in {seconds((end_ns - begin_ns) / 1e9)}{repeated}"
    )
