"""What the shape rests on, from base to tip: how well its depth can be told, how exact it is, and what each camera saw."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nodal.report.pictures.estimate.look import SMALL_PT, caption, heading, page
from nodal.report.pictures.estimate.subject import Subject
from nodal.report.pictures.paper import COLUMN_IN
from nodal.report.pictures.style import DESIRED, GRID, INK, MEASURED, NODE, PALETTE

Array = NDArray[np.float64]
Panel = tuple[str, float, Callable[[Any, Subject], None]]

FRAME_IN = 1.0
BAR = 0.55
FINE = 321
"""Places along the centreline, which a method may give by few points."""
FAR, LEAST_PX = 3.0, 0.2
"""Offsets are shown up to so many times the one that nine in ten stay below, and at least up to so many px."""
WIDE_RANGE = 8.0
"""From this ratio of largest to smallest on, a scale is logarithmic."""


def draw_along(path: Path, subject: Subject, written: list[Path]) -> None:
    """Panels one below another over the distance from the base."""
    panels = _panels(subject)
    heights_in = [height_in for _, height_in, _ in panels]
    with page(path, COLUMN_IN, sum(heights_in) + FRAME_IN, written) as figure:
        column = figure.subplots(
            len(panels), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights_in}
        )[:, 0]
        for axes, (title, _, draw) in zip(column, panels, strict=True):
            draw(axes, subject)
            axes.set_title(title, fontsize=7)
        column[-1].set(
            xlabel="distance from the base along the centreline, mm",
            xlim=(0, max(subject.shape.length_mm, float(subject.nodes.arc_mm[-1])) * 1.01),
        )
        heading(figure, subject.verdict, bad=bool(subject.shape.flags))
        caption(figure, f"{subject.figures}.")


def _panels(subject: Subject) -> list[Panel]:
    """Title, height in inches, and what draws it; those that have something to show."""
    panels: list[Panel] = [
        ("Angle to the epipolar direction, degrees", 0.85, _angle),
        ("Standard deviation in the worst direction, mm", 0.95, _spread),
    ]
    if subject.agreements:
        panels += [
            ("Measured midline off the reprojected shape, px", 1.0, _offsets),
            ("Where each camera saw both edges", 0.1 + 0.27 * len(subject.agreements), _stretches),
        ]
    if subject.shape.stages:
        panels.append(("Ray gap of triangulated points, mm (line: mean)", 0.95, _gaps))
    return panels


def _angle(axes: Any, subject: Subject) -> None:
    angle_deg = np.degrees(subject.shape.evidence.epipolar_angle_rad)
    axes.plot(subject.shape.centreline.arc_mm, angle_deg, color=MEASURED)
    axes.set(ylim=(0, 92), yticks=(0, 30, 60, 90))


def _spread(axes: Any, subject: Subject) -> None:
    arc_mm = np.linspace(0.0, subject.shape.length_mm, FINE)
    sigma_mm = _worst_mm(subject.shape.centreline.at(arc_mm)[1])
    nodes_mm = _worst_mm(subject.node_covariance_mm2)
    axes.plot(arc_mm, sigma_mm, color=MEASURED)
    axes.plot(subject.nodes.arc_mm, nodes_mm, "o", color=NODE, markersize=3)
    for name, arc, sigma in zip(subject.nodes.names, subject.nodes.arc_mm, nodes_mm, strict=True):
        axes.annotate(name, (arc, sigma), (0, 4), textcoords="offset points", ha="center", fontsize=SMALL_PT)
    _scale(axes, np.concatenate([sigma_mm, nodes_mm]))


def _offsets(axes: Any, subject: Subject) -> None:
    """What lies far off is shown as an arrow at the edge: it would hide how small the rest is."""
    offsets_px = np.concatenate([one.offset_px[one.seen] for one in subject.agreements.values()])
    typical_px = float(np.percentile(np.abs(offsets_px), 90)) if len(offsets_px) else 0.0
    limit_px = max(FAR * typical_px, LEAST_PX)
    axes.axhline(0, color=DESIRED, linewidth=0.6)
    for colour, (name, agreement) in zip(PALETTE, subject.agreements.items(), strict=False):
        rms_px = subject.shape.evidence.residual_px[name]
        axes.plot(
            agreement.arc_mm,
            np.clip(agreement.offset_px, -limit_px, limit_px),
            color=colour,
            linewidth=0.8,
            label=f"{name} ({rms_px:.2f} RMS)",
        )
        for far, marker, edge in (
            (agreement.offset_px > limit_px, "^", 0.93 * limit_px),
            (agreement.offset_px < -limit_px, "v", -0.93 * limit_px),
        ):
            axes.plot(agreement.arc_mm[far], np.full(far.sum(), edge), marker, color=colour, markersize=3)
    rows = -(-len(subject.agreements) // 2)
    axes.set(ylim=(-limit_px, (1 + 0.5 * rows) * limit_px))
    axes.legend(loc="upper right", ncols=2, borderaxespad=0.1, columnspacing=1, fontsize=SMALL_PT)


def _stretches(axes: Any, subject: Subject) -> None:
    names = list(subject.agreements)
    for row, (colour, agreement) in enumerate(zip(PALETTE, subject.agreements.values(), strict=False)):
        axes.barh(row, subject.shape.length_mm, BAR, color=GRID, linewidth=0)
        axes.broken_barh(agreement.stretches_mm(), (row - BAR / 2, BAR), color=colour, linewidth=0)
    visible = subject.shape.evidence.visible_mm
    axes.set_yticks(
        range(len(names)), [f"{name}\n{visible[name]:.0f} mm" for name in names], fontsize=SMALL_PT
    )
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")


def _gaps(axes: Any, subject: Subject) -> None:
    stages = subject.shape.stages
    if stages is None:
        return
    arc_mm = np.linspace(0.0, subject.shape.length_mm, FINE)
    line, _ = subject.shape.centreline.at(arc_mm)
    nearest = np.linalg.norm(stages.points_mm[:, None] - line, axis=2).argmin(axis=1)
    axes.plot(arc_mm[nearest], stages.gaps_mm, ".", color=INK, markersize=2.5, markeredgewidth=0)
    axes.axhline(subject.shape.evidence.ray_gap_mm, color=MEASURED, linewidth=0.8)
    axes.set_ylim(bottom=0)


def _scale(axes: Any, values: Array) -> None:
    """Logarithmic where the range is wide, from nothing otherwise; room for names above."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: PLC0415  part of an extra

    low, high = max(float(values.min()), 1e-6), float(values.max())
    if high > WIDE_RANGE * low:
        axes.set(yscale="log", ylim=(low / 1.3, high * (high / low) ** 0.25))
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(0, 1.25 * high)


def _worst_mm(covariance_mm2: Array) -> Array:
    return np.asarray(np.sqrt(np.linalg.eigvalsh(covariance_mm2)[:, -1]))
