"""Draws charts: onto the axes of any figure, or as SVG that takes its colours from the page."""

import dataclasses
import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nodal.report.charts import Band, Chart, Series, thinned
from nodal.report.pictures.style import FAINT, INK, PAGE_COLOURS, PALETTE, STATES, drawing

WIDE_IN, NARROW_IN, HIGH_IN = 9.4, 4.6, 2.9
LOW_IN, ROW_IN = 1.1, 0.26
FEW_DECADES = 10**2.5
ROOM_FOR_A_NAME = 0.05

ROOT = re.compile(r"<svg .*</svg>", re.DOTALL)
UNWANTED = re.compile(
    r"<metadata>.*?</metadata>|<!--.*?-->|<style.*?</style>"
    r"| (width|height)=\"[0-9.]+pt\"| xmlns(:xlink)?=\"[^\"]*\"| version=\"1.1\""
    r"| id=\"[A-Za-z0-9_.]+_[0-9]+\"| ?font-family: [^;\"]*;?",
    re.DOTALL,
)
"""What only a file of its own needs; the page has one font and one set of names."""


def as_svg(chart: Chart, salt: str) -> str:
    """An `svg` element without its title, in the page's colours; NodalError without matplotlib.

    Names inside it differ from those of any picture with another salt.
    """
    height = NARROW_IN if chart.equal else HIGH_IN
    if chart.rows is not None:
        height = LOW_IN + ROW_IN * len(chart.rows)
    with drawing(WIDE_IN if chart.wide else NARROW_IN, height, salt) as figure:
        draw(figure.subplots(), dataclasses.replace(chart, title=""))
        return page_svg(figure)


def page_svg(figure: Any) -> str:
    """A figure of `drawing` as an `svg` element in the page's colours."""
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=True)
    found = ROOT.search(text.getvalue())
    svg = UNWANTED.sub("", found[0] if found else "").replace("xlink:href", "href")
    for name, colour in PAGE_COLOURS.items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg


def draw(axes: Any, chart: Chart) -> None:
    """Series over bands, with labels, and a legend where there is more than one."""
    _show_bands(axes, chart.bands)
    for series in chart.series:
        _show(axes, thinned(series))
    if chart.logarithmic and any((getattr(series, chart.logarithmic) > 0).any() for series in chart.series):
        _make_logarithmic(axes, chart.logarithmic)
    axes.set(title=chart.title, xlabel=chart.x_label, ylabel=chart.y_label)
    if chart.rows is not None:
        axes.set_yticks(range(len(chart.rows)), chart.rows)
        axes.set_ylim(-0.7, len(chart.rows) + 0.3)
        axes.grid(visible=False, axis="y")
    elif len(chart.series) > 1:
        axes.legend(
            loc="lower right",
            bbox_to_anchor=(1, 1),
            ncols=len(chart.series),
            borderaxespad=0.2,
            columnspacing=1.2,
        )
    if chart.equal:
        axes.set_aspect("equal", adjustable="datalim")


def _show(axes: Any, series: Series) -> None:
    colour = PALETTE[series.colour % len(PALETTE)] if series.colour >= 0 else INK
    if series.style == "ticks":
        axes.plot(series.x, series.y, "|", color=colour, markersize=9, markeredgewidth=1.2)
    elif series.style == "steps":
        axes.fill_between(series.x, series.y, step="post", color=colour, alpha=0.18, linewidth=0)
        axes.plot(series.x, series.y, drawstyle="steps-post", color=colour, label=series.label)
    elif series.style == "dashes":
        axes.plot(series.x, series.y, "--", color=colour, linewidth=1.0, label=series.label)
    else:
        axes.plot(series.x, series.y, color=colour, linewidth=1.1, label=series.label)
        alone = _alone(series)
        axes.plot(series.x[alone], series.y[alone], ".", color=colour, markersize=2.5)


def _alone(series: Series) -> NDArray[np.bool_]:
    """(N,) the points that a line would not show, because nothing known stands beside them."""
    known = np.isfinite(series.x) & np.isfinite(series.y)
    around = np.pad(known, 1)
    return known & ~around[:-2] & ~around[2:]


def _make_logarithmic(axes: Any, which: str) -> None:
    """With few and plain numbers beside it."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: PLC0415  part of an extra

    axes.set(**{f"{which}scale": "log"})
    axis = getattr(axes, f"{which}axis")
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < FEW_DECADES * low else (1,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _show_bands(axes: Any, bands: tuple[Band, ...]) -> None:
    """What was going on behind the curves; its name where there is room for it."""
    if not bands:
        return
    whole_s = bands[-1].end_s - bands[0].begin_s
    for before, band in zip((None, *bands), bands, strict=False):
        axes.axvspan(band.begin_s, band.end_s, color=STATES.get(band.state, FAINT), alpha=0.35, linewidth=0)
        if before is not None and before.state == band.state:
            axes.axvline(band.begin_s, color=FAINT, linewidth=0.5)
        if band.end_s - band.begin_s > ROOM_FOR_A_NAME * whole_s:
            axes.text(
                (band.begin_s + band.end_s) / 2,
                0.97,
                band.label,
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="top",
                fontsize=8,
                clip_on=True,
            )
