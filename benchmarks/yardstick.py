"""Lines that hold what was measured against what was asked for: yardstick, measured, met or missed."""


def yardstick(name: str, asked: str, measured: str, *, met: bool) -> str:
    """One line of the table."""
    return f"{name + ' ' + asked:<92}{measured:>28}  {'met' if met else 'MISSED'}"


def most_mm(name: str, measured_mm: float, most_mm: float) -> str:
    """A length in mm that should be at most so much."""
    return yardstick(name, f"<= {most_mm:g} mm", f"{measured_mm:.4f} mm", met=measured_mm <= most_mm)


def most_ratio(name: str, taken_s: float, most: float, other_s: float, other: str) -> str:
    """A time that should be at most so many times another of the same run."""
    ratio = taken_s / other_s
    return yardstick(
        name,
        f"<= {most:g} x {other}",
        f"{ratio:.2f} x ({1e3 * taken_s:.1f} / {1e3 * other_s:.1f} ms)",
        met=ratio <= most,
    )


def least_ratio(name: str, taken_s: float, least: float, other_s: float, other: str) -> str:
    """A time that should be at least so many times shorter than another of the same run."""
    ratio = other_s / taken_s
    return yardstick(
        name,
        f">= {least:g} x faster than {other}",
        f"{ratio:.0f} x ({1e3 * taken_s:.1f} / {1e3 * other_s:.0f} ms)",
        met=ratio >= least,
    )
