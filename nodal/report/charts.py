"""Charts of a run as data: series, bands and labels. Pure; nodal/report/pictures/chart.py draws them."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from messaging.control import State
from nodal.report.stretches import Stretch

Array = NDArray[np.float64]
Style = Literal["line", "dashes", "steps", "ticks"]

MOST_POINTS = 1600
"""A line of more is thinned out for drawing; its extremes stay."""
SILENCE_S = 0.25
TIME = "time since the recording began, s"
FLOOR_MM = 1e-3
"""Less than this is the same on a logarithmic scale."""
EDGES_MS = np.geomspace(0.01, 10_000, 73)
"""The same for all durations, so that histograms of different runs can lie over one another."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Points (N,) joined by a line, which NaN interrupts, or drawn one by one. `colour` counts in the palette."""

    label: str
    x: Array
    y: Array
    colour: int = 0
    style: Style = "line"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Band:
    """A stretch of time in which one thing went on."""

    begin_s: float
    end_s: float
    state: State
    label: str


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Chart:
    """What one picture shows; the first of its series stands for the run where runs are compared."""

    key: str
    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    logarithmic: Literal["", "x", "y"] = ""
    equal: bool = False
    bands: tuple[Band, ...] = ()
    rows: tuple[str, ...] | None = None
    """Names instead of numbers on the y axis; they may be none, for bands alone."""
    wide: bool = False

    def in_words(self) -> str:
        """For who cannot see it: what is drawn, and between which values it lies."""
        said = [
            f"{self.title}. Across: {self.x_label}. Up: {', '.join(self.rows or ()) or self.y_label or 'nothing'}."
        ]
        for series in self.series:
            known = series.y[np.isfinite(series.y)]
            if self.rows is not None:
                said.append(f"{series.label}: {len(known)}.")
            elif len(known):
                said.append(
                    f"{series.label}: {known.min():.4g} to {known.max():.4g}, median {np.median(known):.4g}."
                )
        return " ".join(said)


def line(label: str, x: ArrayLike, y: ArrayLike, colour: int = 0, style: Style = "line") -> Series:
    """A series of any two sequences of the same length, thinned out to what can be seen."""
    x_array, y_array = np.asarray(x, np.float64), np.asarray(y, np.float64)
    return Series(label=label, x=x_array, y=y_array, colour=colour, style=style)


def over_time(label: str, time_s: ArrayLike, values: ArrayLike, colour: int = 0) -> Series:
    """A line that breaks where nothing was heard for `SILENCE_S`."""
    times, heights = np.asarray(time_s, np.float64), np.asarray(values, np.float64)
    silences = np.flatnonzero(np.diff(times) > SILENCE_S) + 1
    return line(label, np.insert(times, silences, np.nan), np.insert(heights, silences, np.nan), colour)


def thinned(series: Series) -> Series:
    """A line over increasing x with at most `MOST_POINTS` points: of each short stretch its lowest and its highest."""
    if series.style != "line" or len(series.x) <= MOST_POINTS:
        return series
    kept = []
    for rows in np.array_split(np.arange(len(series.x)), MOST_POINTS // 2):
        known = rows[np.isfinite(series.y[rows])]
        # a stretch without any value stays an interruption
        kept += (
            sorted({known[series.y[known].argmin()], known[series.y[known].argmax()]})
            if len(known)
            else [rows[0]]
        )
    return dataclasses.replace(series, x=series.x[kept], y=series.y[kept])


def histogram(label: str, values_ms: ArrayLike, colour: int = 0) -> Series:
    """What share of these durations lies in each bin of `EDGES_MS`, in per cent."""
    values = np.clip(np.asarray(values_ms, np.float64), EDGES_MS[0], EDGES_MS[-1])
    counts, _ = np.histogram(values, EDGES_MS)
    occupied = np.flatnonzero(counts)
    if not len(occupied):
        return line(label, [], [], colour, "steps")
    around = slice(max(occupied[0] - 1, 0), occupied[-1] + 3)
    share = np.append(100 * counts / len(values), 0.0)
    return line(label, EDGES_MS[around], share[around], colour, "steps")


def a_second(label: str, time_s: ArrayLike, colour: int = 0) -> Series:
    """How many of these moments lie in each whole second between the first and the last."""
    times = np.asarray(time_s, np.float64)
    edges = np.arange(np.floor(times.min()), np.ceil(times.max()) + 1) if times.size else np.zeros(1)
    # the seconds at both ends are rarely whole
    counts = np.histogram(times, edges)[0][1:-1] if len(edges) > 3 else np.zeros(0)
    return Series(label=label, x=edges[1 : 1 + len(counts)] + 0.5, y=counts.astype(np.float64), colour=colour)


def bands(stretches: Sequence[Stretch], start_ns: int) -> tuple[Band, ...]:
    """What the controller was doing, for the background of a chart over time."""
    found: list[Band] = []
    for stretch in stretches:
        begin_s, end_s = (stretch.begin_ns - start_ns) / 1e9, (stretch.end_ns - start_ns) / 1e9
        band = Band(begin_s=begin_s, end_s=end_s, state=stretch.state, label=phase(stretch))
        if found and (found[-1].label, found[-1].end_s) == (band.label, begin_s):
            found[-1] = dataclasses.replace(found[-1], end_s=end_s)
        else:
            found.append(band)
    return tuple(found)


def phase(stretch: Stretch) -> str:
    """One word: the target while tracking, the state otherwise."""
    if stretch.state is State.TRACKING:
        return stretch.target_name.removeprefix("demo-")
    return "holding" if stretch.state is State.HOLD else str(stretch.state)


def overlaid(charts: Mapping[str, Chart]) -> Chart:
    """One chart of the leading series of charts of the same kind, by the name of the run that each is of."""
    first = next(iter(charts.values()))
    series = tuple(
        dataclasses.replace(chart.series[0], label=name, colour=number)
        for number, (name, chart) in enumerate(charts.items())
    )
    title = f"{first.title}: {first.series[0].label}" if len(first.series) > 1 else first.title
    return dataclasses.replace(first, title=title, series=series, bands=())
