"""Draws figures for a paper: of a page's width, in type that journals can embed, in every format that is asked for."""

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nodal.exports.plots.figures import Figure, figures
from nodal.report.findings import Findings
from nodal.report.pictures.chart import draw
from nodal.report.pictures.paper import PAGE_IN, paper
from nodal.report.pictures.style import FAINT, INK, MEASURED, robot_axes
from nodal.report.tracking import Tracking

Array = NDArray[np.float64]

ROW_IN, PATH_IN = 2.1, 6.4
ROOM_ABOVE = 0.14
PATH, PATH_NEEDS = "path", "shape, controller/state and target"
PLANES = (("From above", 0, 1), ("From the front", 0, 2), ("From the side", 1, 2))


def draw_figures(
    findings: Findings, folder: Path, formats: Iterable[str]
) -> tuple[list[Path], dict[str, str]]:
    """Files by figure and format, and what the figures that were left out need; raises NodalError without matplotlib."""
    written: list[Path] = []
    left_out: dict[str, str] = {}
    for figure in figures(findings):
        if figure.rows:
            with paper(folder / figure.name, PAGE_IN, ROW_IN * len(figure.rows), formats, written) as page:
                _fill(page, figure)
        else:
            left_out[figure.name] = figure.needs
    if any(len(tracking.time_ns) for tracking in findings.tracking.values()):
        with paper(folder / PATH, PAGE_IN, PATH_IN, formats, written) as page:
            _draw_path(page, findings)
    else:
        left_out[PATH] = PATH_NEEDS
    return written, left_out


def _fill(page: Any, figure: Figure) -> None:
    columns = max(len(row) for row in figure.rows)
    grid = page.subplots(len(figure.rows), columns, sharex=figure.one_time_axis, squeeze=False)
    explained: list[str] = []
    for row, charts in zip(grid, figure.rows, strict=True):
        for axes, chart in zip_longest(row, charts):
            if chart is None:
                axes.remove()
                continue
            draw(axes, chart)
            if chart.bands:
                _make_room_above(axes)
            labels = axes.get_legend_handles_labels()[1]
            if (legend := axes.get_legend()) and labels == explained:
                legend.remove()
            explained = labels
    page.align_ylabels()
    if figure.one_time_axis:
        for axes in grid[:-1].flat:
            axes.set_xlabel("")


def _make_room_above(axes: Any) -> None:
    """For the names of the bands, which stand inside."""
    scale = axes.yaxis.get_transform()
    low, high = scale.transform(axes.get_ylim())
    axes.set_ylim(top=scale.inverted().transform(high + ROOM_ABOVE * (high - low)))


def _draw_path(page: Any, findings: Findings) -> None:
    """In space with the robot at its furthest, and in three planes."""
    trackings = [tracking for tracking in findings.tracking.values() if len(tracking.time_ns)]
    lines = {
        "target": (_lines(trackings, "desired_mm"), INK, "--"),
        "true" if findings.true else "measured": (_lines(trackings, "reached_mm"), MEASURED, "-"),
    }
    robot_mm = max(findings.run.usable, key=lambda shape: np.hypot(*shape.node_mm[-1, :2])).centreline_mm
    places_mm = np.concatenate([robot_mm, *(places for places, _, _ in lines.values())])
    grid = page.add_gridspec(2, 2)
    in_space = robot_axes(page, grid[0, 0], places_mm[np.isfinite(places_mm).all(axis=1)])
    in_space.plot(*robot_mm.T, color=FAINT, linewidth=3, label="robot")
    in_space.set_title("In space")
    for axis in (in_space.xaxis, in_space.yaxis):
        axis.get_major_locator().set_params(nbins=4)
    in_space.set_box_aspect((1, 1, 1), zoom=0.95)
    for label, (places, colour, style) in lines.items():
        in_space.plot(*places.T, style, color=colour, label=label)
    for position, (title, across, up) in zip((grid[0, 1], grid[1, 0], grid[1, 1]), PLANES, strict=True):
        axes = page.add_subplot(position)
        for places, colour, style in lines.values():
            axes.plot(places[:, across], places[:, up], style, color=colour)
        axes.set(title=title, xlabel=f"{'xyz'[across]}, mm", ylabel=f"{'xyz'[up]}, mm")
        axes.set_aspect("equal", adjustable="datalim")
    page.legend(*in_space.get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _lines(trackings: Sequence[Tracking], which: str) -> Array:
    """(N, 3) the paths of all points that count, one after another, with a row of NaN between them."""
    pieces = []
    for tracking in trackings:
        for path_mm in np.swapaxes(getattr(tracking, which), 0, 1):
            pieces += [path_mm, np.full((1, 3), np.nan)]
    return np.concatenate(pieces)
