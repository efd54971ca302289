"""Figures as people read them."""

import time

from nodal.report.figures.model import Figure

DIGITS = {"mm": 3, "px": 3, "ms": 1, "s": 2, "Hz": 1, "%": 1, "mA": 0, "°C": 1, "V": 1, "MB": 2, "°": 1}
NOTHING = "–"
MINUS = "−"
THIN_SPACE = "\u202f"


def shown(figure: Figure) -> str:
    """The value with its unit."""
    return with_unit(figure.value, figure.unit)


def with_unit(value: float | None, unit: str) -> str:
    """With as many digits as the unit deserves; a dash for nothing."""
    if value is None:
        return NOTHING
    number = f"{value:,.{DIGITS.get(unit, 0)}f}".replace(",", THIN_SPACE).replace("-", MINUS)
    return f"{number}{THIN_SPACE}{unit}" if unit else number


def difference(value: float | None, base: float | None, unit: str) -> str:
    """Signed, and in per cent where there is something to divide by; nothing where both read the same."""
    if value is None or base is None or with_unit(value, unit) == with_unit(base, unit):
        return ""
    change = value - base
    sign = "+" if change > 0 else ""
    percent = f"{100 * change / base:.0f}" if base and unit != "%" else "0"
    relative = "" if percent in ("0", "-0") else f" ({sign}{percent} %)".replace("-", MINUS)
    return f"{sign}{with_unit(change, unit)}{relative}"


def utc(time_ns: int) -> str:
    """A Unix time in ns as date and time."""
    return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(time_ns // 10**9))


def megabytes(size_bytes: int) -> str:
    """A size."""
    return with_unit(size_bytes / 1e6, "MB")
