"""Why there is no shape: what each camera saw, how far that differs from the backdrop, and what was taken for the robot."""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nodal.report.pictures.estimate.look import SEEN, SMALL_PT, caption, halo, heading, page
from nodal.report.pictures.paper import PAGE_IN
from nodal.report.pictures.style import NODE
from sensing.errors import RefusedError, SensingError
from sensing.geometry.camera import Camera
from sensing.pictures.segmentation import BaseView, robot_mask
from sensing.scene import Scene

Array = NDArray[np.float64]
COLUMNS = ("source", "colour distance from the backdrop", "taken for the robot")
FRAME_IN, BAD_ROW_IN = 0.85, 0.5
LETTERS = 44
AXIS_MM = 15.0
"""The robot's beginning is marked along +Z so far."""
MOST_DISTANCE = 99.9
EXPLAINED = (
    "Blue: the base and its +Z as the calibration has them. Red: the work area, where one is set. The colour distance is "
    "that of equation 1, in levels; what was taken for the robot is cut out as the method refined does it."
)


@dataclass(frozen=True, eq=False)
class Sight:
    """One camera's picture (H, W, 3) in RGB, and its colour distance from the backdrop (h, w) in detection pixels.

    `mask` (h, w) is what was taken for the robot, or `problem` says why nothing was.
    """

    picture: NDArray[np.uint8]
    distance: NDArray[np.float32]
    mask: NDArray[np.uint8] | None
    problem: str


def draw_refused(
    path: Path,
    scene: Scene,
    jpegs: Mapping[str, bytes],
    insertion_mm: float,
    reason: str,
    written: list[Path],
) -> None:
    """A row for each camera; a picture that cannot be used is a row of words."""
    sights = {camera.name: _sight(scene, camera, jpegs, insertion_mm) for camera in scene.cameras}
    width_in = PAGE_IN / len(COLUMNS)
    heights_in = [
        width_in * camera.size_px[1] / camera.size_px[0]
        if isinstance(sights[camera.name], Sight)
        else BAD_ROW_IN
        for camera in scene.cameras
    ]
    with page(path, PAGE_IN, sum(heights_in) + FRAME_IN, written) as figure:
        grid = figure.subplots(
            len(heights_in), len(COLUMNS), squeeze=False, gridspec_kw={"height_ratios": heights_in}
        )
        for row, camera in zip(grid, scene.cameras, strict=True):
            row[0].set_ylabel(f"camera {camera.name}", fontsize=8, fontweight="bold")
            for axes in row:
                axes.set(xticks=(), yticks=())
                axes.spines[:].set_visible(False)
                axes.grid(visible=False)
            _draw_row(figure, row, scene, camera, sights[camera.name], insertion_mm)
        for axes, title in zip(grid[0], COLUMNS, strict=True):
            axes.set_title(title, loc="center")
        heading(figure, f"Refused: {reason}", bad=True)
        caption(figure, EXPLAINED)


def _sight(scene: Scene, camera: Camera, jpegs: Mapping[str, bytes], insertion_mm: float) -> Sight | str:
    """What there is to show of a camera, or why there is nothing."""
    if camera.name not in jpegs:
        return f"camera {camera.name} gave no picture"
    try:
        picture = scene.picture(camera.name, jpegs[camera.name])
        backdrop = scene.backdrop(picture)
        small = picture.reduced(backdrop.grid.step)
        distance = backdrop.distance(small)
        colour = np.ascontiguousarray(picture.colour[..., ::-1])
    except SensingError as error:
        return str(error)
    try:
        base = BaseView.of(camera, insertion_mm)
        return Sight(
            colour, distance, robot_mask(camera.name, small, backdrop, base, scene.limits(camera.name)), ""
        )
    except RefusedError as error:
        return Sight(colour, distance, None, str(error))


def _draw_row(
    figure: Any, row: Sequence[Any], scene: Scene, camera: Camera, sight: Sight | str, insertion_mm: float
) -> None:
    if isinstance(sight, str):
        row[0].text(0.02, 0.5, sight, transform=row[0].transAxes, va="center", fontsize=SMALL_PT, color=NODE)
        return
    width, height = camera.size_px
    extent = (-0.5, width - 0.5, height - 0.5, -0.5)
    row[0].imshow(sight.picture, extent=extent, interpolation="antialiased")
    most = max(float(np.percentile(sight.distance, MOST_DISTANCE)), 1.0)
    shown = row[1].imshow(
        sight.distance, extent=extent, cmap="magma", vmin=0, vmax=most, interpolation="antialiased"
    )
    bar = figure.colorbar(shown, ax=row[1], location="right", shrink=0.8, pad=0.02, aspect=18)
    bar.ax.tick_params(labelsize=SMALL_PT, length=2)
    bar.outline.set_visible(False)
    if sight.mask is None:
        words = "\n".join(textwrap.wrap(sight.problem, LETTERS))
        row[2].imshow(np.zeros_like(sight.distance), extent=extent, cmap="gray", vmin=0, vmax=255)
        row[2].text(
            0.5, 0.8, words, transform=row[2].transAxes, ha="center", va="center", fontsize=6, color="white"
        )
    else:
        row[2].imshow(sight.mask, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axis = camera.project(np.array([[0.0, 0.0, insertion_mm], [0.0, 0.0, insertion_mm + AXIS_MM]]))
    for axes in row:
        axes.set(xlim=extent[:2], ylim=extent[2:])
        axes.plot(*axis.T, color=SEEN, linewidth=1.2, clip_on=True)
        axes.plot(*axis[:1].T, "o", color=SEEN, markersize=3, path_effects=halo(1.2), clip_on=True)
        if (area := scene.work_areas.get(camera.name)) is not None:
            axes.plot(*np.vstack([area, area[:1]]).T, color=NODE, linewidth=0.8)
