"""What each camera saw: source, silhouette, midline, and the shape laid over the picture again."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nodal.errors import ReportError
from nodal.report.pictures.estimate.labels import alignment, label_places
from nodal.report.pictures.estimate.look import SEEN, SMALL_PT, caption, halo, heading, page
from nodal.report.pictures.estimate.regions import Region, magnification
from nodal.report.pictures.estimate.subject import Subject
from nodal.report.pictures.paper import PAGE_IN
from nodal.report.pictures.style import INK, NODE, WITHOUT_FEEDBACK
from nodal.report.pictures.views import View
from sensing.geometry.camera import Camera
from sensing.shape import Silhouette

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

COLUMNS = ("source", "silhouette", "midline", "shape")
ROOM = 0.11
"""The largest ellipse's semi-axis, as a share of a picture's height."""
TALLEST_ROW_IN = 3.0
FRAME_IN = 0.75
SILHOUETTE_GREY = 105
BAR_MM = 10.0
HALF_TUBE_MM = 3.5
NAME_PT = 2.0
"""From the robot or an ellipse to a name."""


def draw_cameras(path: Path, subject: Subject, written: list[Path]) -> None:
    """A row for each camera; raises ReportError when no camera's picture can be shown."""
    views = {camera.name: _view(subject, camera) for camera in subject.cameras}
    shown = {name: view for name, view in views.items() if isinstance(view, View)}
    if not shown:
        raise ReportError(f"no camera's picture can be shown: {'; '.join(map(str, views.values()))}")
    ellipses = {name: subject.ellipses(view.camera) for name, view in shown.items()}
    factor = magnification(
        max(region.reach / _height_px(shown[name]) for name, of_one in ellipses.items() for region in of_one),
        ROOM,
    )
    width_in = PAGE_IN / len(COLUMNS)
    heights_in = [
        min(width_in * _height_px(view) / _width_px(view), TALLEST_ROW_IN) if isinstance(view, View) else 0.5
        for view in views.values()
    ]
    with page(path, PAGE_IN, sum(heights_in) + FRAME_IN, written) as figure:
        grid = figure.subplots(
            len(views), len(COLUMNS), squeeze=False, gridspec_kw={"height_ratios": heights_in}
        )
        for row, (name, view) in zip(grid, views.items(), strict=True):
            row[0].set_ylabel(f"camera {name}", fontsize=8, fontweight="bold")
            if isinstance(view, View):
                _draw_row(row, subject, view, ellipses[name], factor)
            else:
                _say_why(row, view)
        for axes, title in zip(grid[0], COLUMNS, strict=True):
            axes.set_title(title, loc="center")
        heading(figure, subject.verdict, bad=bool(subject.shape.flags))
        caption(figure, f"{_explained(factor)}\n{subject.figures}.")


def _explained(factor: int) -> str:
    size = f", magnified {factor} times (the bar's {BAR_MM:g} mm are {BAR_MM / factor:g} mm of an ellipse)"
    return (
        "Midline: orange, the silhouette's skeleton; white, as measured. Shape: dashed where the camera did not see both "
        f"edges; ellipses hold the nodal points with 95 % confidence{size if factor > 1 else ''}."
    )


def _view(subject: Subject, camera: Camera) -> View | str:
    """The camera's view, or why there is none."""
    if camera.name not in subject.jpegs:
        return f"camera {camera.name} gave no picture"
    try:
        return View.around(camera, subject.jpegs[camera.name], subject.shape.centreline.points_mm)
    except ReportError as error:
        return str(error)


def _draw_row(
    row: Sequence[Any], subject: Subject, view: View, ellipses: Sequence[Region], factor: int
) -> None:
    source, silhouette, midline, detected = row
    stages, agreement = subject.shape.stages, subject.agreements.get(view.camera.name)
    show(source, view, view.picture)
    found = stages.silhouettes.get(view.camera.name) if stages else None
    if found:
        show(silhouette, view, _mask(found, view, 255))
        show(midline, view, _mask(found, view, SILHOUETTE_GREY))
        midline.plot(*found.skeleton.T, ".", color=WITHOUT_FEEDBACK, markersize=2.8, markeredgewidth=0)
    else:
        for axes in (silhouette, midline):
            show(axes, view, np.zeros_like(view.picture))
        _write(silhouette, "followed from the shape\nbefore: none was sought")
    if agreement is not None:
        midline.plot(*agreement.measured_px.T, color="white", linewidth=0.7)
    show(detected, view, view.picture)
    _draw_shape(detected, subject, view.camera)
    _draw_nodes(detected, subject, view, ellipses, factor)
    _draw_bar(detected, subject, view)


def _draw_shape(axes: Any, subject: Subject, camera: Camera) -> None:
    """The reprojected centreline: whole where the camera saw both edges, dashed elsewhere."""
    agreement = subject.agreements.get(camera.name)
    if agreement is None:
        axes.plot(*camera.project(subject.shape.centreline.points_mm).T, color=SEEN, linewidth=1.1)
        return
    line = camera.project(subject.shape.centreline.at(agreement.arc_mm)[0])
    for seen, dashes in ((agreement.seen, "-"), (agreement.unseen, (0, (1.2, 1)))):
        axes.plot(*np.where(seen[:, None], line, np.nan).T, color=SEEN, linewidth=1.1, linestyle=dashes)


def _draw_nodes(axes: Any, subject: Subject, view: View, ellipses: Sequence[Region], factor: int) -> None:
    """Nodal points with their ellipses and their names."""
    line = view.camera.project(subject.shape.centreline.points_mm)
    centres = np.array([ellipse.centre for ellipse in ellipses])
    point_px = _width_px(view) / (72 * PAGE_IN / len(COLUMNS))
    tube_px = HALF_TUBE_MM * _px_per_mm(subject, view)
    away = np.array([max(factor * one.reach, tube_px) + NAME_PT * point_px for one in ellipses])
    x0, y0, x1, y1 = view.part
    places = label_places(line, centres, away, np.array([x0, y0]), np.array([x1, y1]))
    for name, ellipse, place in zip(subject.nodes.names, ellipses, places, strict=True):
        outline = ellipse.surface(factor).T
        axes.fill(*outline, color=NODE, alpha=0.3, linewidth=0)
        axes.plot(*outline, color=NODE, linewidth=0.8, path_effects=halo(1.4))
        axes.plot(*ellipse.centre, "o", color="white", markersize=1.3, markeredgewidth=0)
        rightwards, downwards = place - ellipse.centre
        axes.text(
            *place,
            name,
            fontsize=SMALL_PT,
            color=INK,
            path_effects=halo(),
            clip_on=True,
            **alignment(rightwards, -downwards),
        )


def _draw_bar(axes: Any, subject: Subject, view: View) -> None:
    """A bar of 10 mm, at the scale half way along the robot, in the corner."""
    length_px = BAR_MM * _px_per_mm(subject, view)
    x0, _, _, y1 = view.part
    left, down = x0 + 0.05 * _width_px(view), y1 - 0.035 * _height_px(view)
    axes.plot([left, left + length_px], [down, down], color=INK, linewidth=1.6, path_effects=halo(2.6))
    axes.annotate(
        f"{BAR_MM:g} mm",
        (left + length_px / 2, down),
        (0, 3),
        textcoords="offset points",
        ha="center",
        fontsize=SMALL_PT,
        path_effects=halo(),
    )


def show(axes: Any, view: View, source: Image) -> None:
    """The part of a picture of full size that shows the robot."""
    part, extent = view.shown(source)
    axes.imshow(part, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axes.set(xticks=(), yticks=(), xlim=extent[:2], ylim=extent[2:])
    axes.spines[:].set_visible(False)
    axes.grid(visible=False)


def _mask(silhouette: Silhouette, view: View, level: int) -> Image:
    size = view.picture.shape[1::-1]
    mask = cv2.resize(np.uint8(level) * (silhouette.mask > 0), size, interpolation=cv2.INTER_NEAREST)
    return np.asarray(mask, dtype=np.uint8)


def _say_why(row: Sequence[Any], reason: str) -> None:
    for axes in row:
        axes.set(xticks=(), yticks=())
        axes.spines[:].set_visible(False)
        axes.grid(visible=False)
    row[0].text(0.02, 0.5, reason, transform=row[0].transAxes, va="center", fontsize=SMALL_PT, color=NODE)


def _write(axes: Any, text: str) -> None:
    axes.text(
        0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", fontsize=SMALL_PT, color="white"
    )


def _px_per_mm(subject: Subject, view: View) -> float:
    """Half way along the robot."""
    points = subject.shape.centreline.points_mm
    _, jacobian = view.camera.project_with_jacobian(points[len(points) // 2][None])
    return float(np.linalg.norm(jacobian[0], ord=2))


def _width_px(view: View) -> int:
    return view.part[2] - view.part[0]


def _height_px(view: View) -> int:
    return view.part[3] - view.part[1]
