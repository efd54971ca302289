"""The shape in space: triangulated points, centreline, nodal points with their ellipsoids, and where the cameras stand."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nodal.report.pictures.estimate.labels import alignment, label_places
from nodal.report.pictures.estimate.look import SMALL_PT, caption, heading, page
from nodal.report.pictures.estimate.regions import magnification
from nodal.report.pictures.estimate.subject import Subject
from nodal.report.pictures.paper import PAGE_IN
from nodal.report.pictures.style import DESIRED, INK, MEASURED, NODE, PALETTE
from sensing.geometry.camera import Camera

Array = NDArray[np.float64]

HEIGHT_IN = 3.7
ROBOT, BENCH, GAPS = (0.1, 0.09, 0.45, 0.84), (0.57, 0.09, 0.41, 0.84), (0.07, 0.25, 0.01, 0.5)
"""Where they stand on the page: left, bottom, width, height."""
ROOM = 0.15
"""The largest ellipsoid's semi-axis, as a share of the robot's largest extent."""
NAME_PT = SMALL_PT + 0.5
NAME_AWAY = 0.03
MOST_GAPS = 97
"""Per cent of the gaps that colours tell apart: a single wild pair would leave one colour for all others."""
LEAST_SHARE = 0.4
"""Of the largest axis, that each axis shows at least."""
FRUSTUM = 0.3
"""How far towards the robot a camera's pyramid reaches."""
BEHIND = 0.14
"""How far behind a camera its name stands, as a share of its distance from the robot."""
STRAIGHT_MM = 3.0
MOST_NUMBERS = 4
"""On the longest axis."""
BOX_NORM, SIDE_SHARE, FILLED = 1.83, 0.59, 0.82
"""How matplotlib scales a box: to a diagonal of BOX_NORM, of which one takes SIDE_SHARE of the shorter side of its place."""


@dataclass(frozen=True)
class Sight:
    """From where space is looked at: degrees about Z from X, and above the horizon."""

    azimuth_deg: float
    elevation_deg: float

    @property
    def plane(self) -> Array:
        """Unit vectors (2, 3) to the right and upwards in the picture."""
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        right = [-np.sin(azimuth), np.cos(azimuth), 0.0]
        upwards = [
            -np.cos(azimuth) * np.sin(elevation),
            -np.sin(azimuth) * np.sin(elevation),
            np.cos(elevation),
        ]
        return np.array([right, upwards])


def draw_space(path: Path, subject: Subject, written: list[Path]) -> None:
    """The robot by itself, and with the cameras that look at it; axes have equal scales."""
    with page(path, PAGE_IN, HEIGHT_IN, written) as figure:
        figure.set_layout_engine("none")
        factor = _draw_robot(figure, subject)
        _draw_bench(figure, subject)
        heading(figure, subject.verdict, bad=bool(subject.shape.flags))
        size = f", magnified {factor} times (10 mm on the axes are {10 / factor:g} mm)" if factor > 1 else ""
        caption(figure, f"Ellipsoids hold the nodal points with 95 % confidence{size}.\n{subject.figures}.")


def _draw_robot(figure: Any, subject: Subject) -> int:
    """Returns how much the ellipsoids are magnified."""
    line, stages, ellipsoids = subject.shape.centreline.points_mm, subject.shape.stages, subject.ellipsoids
    extent_mm = max(float(np.ptp(line, axis=0).max()), 1.0)
    factor = magnification(max(region.reach for region in ellipsoids) / extent_mm, ROOM)
    surfaces = [region.surface(factor) for region in ellipsoids]
    sight = _across(line)
    axes = _axes(figure, ROBOT, np.vstack([line, *(surface.reshape(-1, 3) for surface in surfaces)]), sight)
    if stages:
        most_mm = float(np.percentile(stages.gaps_mm, MOST_GAPS))
        gaps = axes.scatter(
            *stages.points_mm.T,
            c=stages.gaps_mm,
            s=6,
            cmap="viridis",
            vmin=0,
            vmax=most_mm,
            linewidths=0,
            alpha=0.9,
        )
        extend = "max" if stages.gaps_mm.max() > most_mm else "neither"
        bar = figure.colorbar(gaps, cax=figure.add_axes(GAPS), location="left", extend=extend)
        bar.set_label("ray gap of the triangulated points, mm", fontsize=SMALL_PT)
        bar.ax.tick_params(labelsize=SMALL_PT, length=2)
        bar.outline.set_visible(False)
    axes.plot(*line.T, color=MEASURED, linewidth=1.1)
    for region, surface in zip(ellipsoids, surfaces, strict=True):
        axes.plot_surface(*np.moveaxis(surface, -1, 0), color=NODE, alpha=0.14, linewidth=0, shade=False)
        for section in region.sections(factor):
            axes.plot(*section.T, color=NODE, linewidth=0.6)
        axes.plot(*region.centre[:, None], "o", color=NODE, markersize=2.2)
    seen = sight.plane @ line.T
    away = np.array([factor * region.reach + NAME_AWAY * extent_mm for region in ellipsoids])
    nodes = subject.node_mm @ sight.plane.T
    places = label_places(seen.T, nodes, away, seen.min(axis=1) - extent_mm, seen.max(axis=1) + extent_mm)
    for name, node_mm, aside in zip(subject.nodes.names, subject.node_mm, places - nodes, strict=True):
        axes.text(*(node_mm + aside @ sight.plane), name, fontsize=NAME_PT, **alignment(*aside))
    axes.set_title("Robot", loc="center", y=0.97)
    return factor


def _draw_bench(figure: Any, subject: Subject) -> None:
    line = subject.shape.centreline.points_mm
    middle = line.mean(axis=0)
    pyramids = {camera.name: _pyramid(camera, middle) for camera in subject.cameras}
    towards = np.mean([pyramid[0] for pyramid in pyramids.values()], axis=0) - middle
    sight = Sight(float(np.degrees(np.arctan2(towards[1], towards[0]))) + 55, 32)
    names = {name: pyramid[0] + BEHIND * (pyramid[0] - middle) for name, pyramid in pyramids.items()}
    axes = _axes(figure, BENCH, np.vstack([line, *pyramids.values(), *names.values()]), sight)
    axes.plot(*line.T, color=MEASURED, linewidth=1.6)
    for colour, (name, pyramid) in zip(PALETTE * len(pyramids), pyramids.items(), strict=False):
        centre, corners = pyramid[0], pyramid[1:]
        axes.plot(*np.vstack([corners, corners[:1]]).T, color=colour, linewidth=0.7)
        for corner in corners:
            axes.plot(*np.vstack([centre, corner]).T, color=colour, linewidth=0.7)
        axes.plot(*np.vstack([centre, middle]).T, color=colour, linewidth=0.6, linestyle=(0, (3, 2)))
        axes.text(*names[name], name, fontsize=NAME_PT, color=colour, ha="center", va="center")
    axes.set_title("Robot and cameras", loc="center", y=0.97)


def _pyramid(camera: Camera, towards_mm: Array) -> Array:
    """The camera's centre and its picture's four corners (5, 3), drawn out a part of the way to a point (3,)."""
    width, height = camera.size_px
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], dtype=np.float64)
    reach = FRUSTUM * float(np.linalg.norm(towards_mm - camera.centre_mm))
    return np.vstack([camera.centre_mm, camera.centre_mm + reach * camera.rays(corners)])


def _across(line_mm: Array) -> Sight:
    """Nearly across the plane in which the robot bends most, and a little from above."""
    aside = line_mm[:, :2] - line_mm[0, :2]
    furthest = aside[np.linalg.norm(aside, axis=1).argmax()]
    bend_deg = float(np.degrees(np.arctan2(furthest[1], furthest[0])))
    return Sight(bend_deg - 65 if np.linalg.norm(furthest) > STRAIGHT_MM else -62, 16)


def _axes(figure: Any, place: tuple[float, float, float, float], points_mm: Array, sight: Sight) -> Any:
    """Axes in mm with equal scales, no larger than these points (n, 3) ask for, seen without perspective."""
    axes = figure.add_axes(place, projection="3d", proj_type="ortho")
    axes.patch.set_visible(False)
    low, high = points_mm.min(axis=0), points_mm.max(axis=0)
    largest = max(float((high - low).max()), 1.0)
    half = np.maximum(high - low, LEAST_SHARE * largest) / 2 + 0.04 * largest
    middle = (low + high) / 2
    for axis, begin, end in zip("xyz", middle - half, middle + half, strict=True):
        axes.set(**{f"{axis}lim": (begin, end), f"{axis}label": f"{axis}, mm"})
    axes.set_box_aspect(half, zoom=_zoom(half, sight, place))
    axes.view_init(elev=sight.elevation_deg, azim=sight.azimuth_deg)
    axes.tick_params(pad=-2, labelsize=SMALL_PT)
    for axis, share in zip((axes.xaxis, axes.yaxis, axes.zaxis), half / half.max(), strict=True):
        axis.get_major_locator().set_params(nbins=max(round(MOST_NUMBERS * float(share)), 2))
        axis.labelpad = -5
        axis.label.set(fontsize=NAME_PT, color=INK)
        axis.set_pane_color((1, 1, 1, 0))
        axis.line.set_color(DESIRED)
    return axes


def _zoom(half_mm: Array, sight: Sight, place: tuple[float, float, float, float]) -> float:
    """With which a box of this half size (3,) fills its place as far as its numbers leave room."""
    corners = np.array(np.meshgrid(*([-0.5, 0.5],) * 3)).reshape(3, -1).T * half_mm
    wide, high = np.ptp(corners @ sight.plane.T, axis=0) * BOX_NORM / float(np.linalg.norm(half_mm))
    width_in, height_in = place[2] * PAGE_IN, place[3] * HEIGHT_IN
    side_in = min(width_in, height_in) * SIDE_SHARE
    return float(min(FILLED * width_in / (wide * side_in), FILLED * height_in / (high * side_in)))
