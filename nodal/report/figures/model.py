"""A figure with its unit, and how figures are grouped. Pure."""

from collections.abc import Iterable

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from nodal.report.statistics import least, mean, most, percentile, rms, rounded

UNITS = {
    "mm": "mm",
    "px": "px",
    "ms": "ms",
    "s": "s",
    "hz": "Hz",
    "percent": "%",
    "ma": "mA",
    "c": "°C",
    "v": "V",
    "mb": "MB",
    "deg": "°",
}
"""By the last word of a figure's key; a figure without one of these is a count."""


class Figure(msgspec.Struct, frozen=True):
    """One value, None where the run holds nothing to make it of. The key names its unit: `rms_mm`."""

    key: str
    label: str
    value: int | float | None

    @property
    def unit(self) -> str:
        """As it is written; empty for a count."""
        return UNITS.get(self.key.rpartition("_")[2], "")


class Group(msgspec.Struct, frozen=True):
    """Figures of one thing: a target, a stage, a topic."""

    title: str
    figures: tuple[Figure, ...]


class Chapter(msgspec.Struct, frozen=True):
    """What belongs together on the page. `minor` figures are folded away where runs are compared."""

    key: str
    title: str
    groups: tuple[Group, ...]
    minor: bool = False


def figures(**labelled: tuple[str, ArrayLike | None]) -> tuple[Figure, ...]:
    """Figures from `key=(label, value)`."""
    return tuple(
        Figure(key, label, int(value) if isinstance(value, int | np.integer) else rounded(value))
        for key, (label, value) in labelled.items()
    )


def spread(values: ArrayLike, unit: str) -> tuple[Figure, ...]:
    """Of a quantity: RMS, mean, 95th percentile, largest."""
    return figures(
        **{
            f"rms_{unit}": ("RMS", rms(values)),
            f"mean_{unit}": ("mean", mean(values)),
            f"p95_{unit}": ("95 % below", percentile(values, 95)),
            f"max_{unit}": ("largest", most(values)),
        }
    )


def durations(values_ms: ArrayLike) -> tuple[Figure, ...]:
    """Of times in ms: how many, median, percentiles, longest."""
    return figures(
        count=("count", np.size(values_ms)),
        p50_ms=("median", percentile(values_ms, 50)),
        p95_ms=("95 % below", percentile(values_ms, 95)),
        p99_ms=("99 % below", percentile(values_ms, 99)),
        max_ms=("longest", most(values_ms)),
    )


def extent(values: ArrayLike, unit: str) -> tuple[Figure, ...]:
    """Of a quantity that may have either sign: least, mean, most."""
    return figures(
        **{
            f"min_{unit}": ("least", least(values)),
            f"mean_{unit}": ("mean", mean(values)),
            f"max_{unit}": ("most", most(values)),
        }
    )


def as_builtins(chapters: Iterable[Chapter]) -> dict[str, dict[str, dict[str, int | float | None]]]:
    """Plain values by chapter, group and figure."""
    return {
        chapter.key: {
            group.title: {figure.key: figure.value for figure in group.figures} for group in chapter.groups
        }
        for chapter in chapters
    }
