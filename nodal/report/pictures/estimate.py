"""One estimate in the manner of the paper's figures 3, 4 and 6."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.frames import CameraCalibration
from messaging.shape import NodalPoints
from nodal.report.pictures.style import MEASURED, NODE, picture, robot_axes
from nodal.report.pictures.views import View, projected
from sensing.shape import Shape

Array = NDArray[np.float64]


def draw_estimate(
    folder: Path,
    jpegs: Mapping[str, bytes],
    rig: Sequence[CameraCalibration],
    shape: Shape,
    nodes: NodalPoints,
) -> list[Path]:
    """All three pictures of an estimate that has its stages; returns the files."""
    views = [View.around(camera, jpegs[camera.camera], shape.centreline.points_mm) for camera in rig]
    return [
        _centreline(folder / "figure-3-centreline.png", views, shape),
        _nodal_points(folder / "figure-4-nodal-points.png", shape, nodes),
        _stages(folder / "figure-6-stages.png", views, shape, nodes),
    ]


def _centreline(path: Path, views: Sequence[View], shape: Shape) -> Path:
    """Figure 3: the triangulated skeleton in space beside what the cameras see."""
    with picture(path, 4.8 + 3.0 * len(views), 4.2) as figure:
        grid = figure.add_gridspec(1, 1 + len(views), width_ratios=(4.8, *(3.0,) * len(views)))
        axes = robot_axes(figure, grid[0], shape.centreline.points_mm)
        if shape.stages:
            x, y, z = shape.stages.points_mm.T
            gaps = axes.scatter(x, y, z, c=shape.stages.gaps_mm, s=14, cmap="viridis", label="triangulated")
            figure.colorbar(gaps, ax=axes, shrink=0.6, pad=0.16, label="gap between paired rays, mm")
        axes.plot(*shape.centreline.points_mm.T, color=MEASURED, label="centreline")
        axes.set_title("Triangulated skeleton and centreline")
        axes.legend(loc="upper left")
        for column, view in enumerate(views, start=1):
            seen = _camera_axes(figure.add_subplot(grid[column]), view, f"camera {view.calibration.camera}")
            seen.plot(*projected(view.calibration, shape.centreline.points_mm).T, color=MEASURED)
    return path


def _nodal_points(path: Path, shape: Shape, nodes: NodalPoints) -> Path:
    """Figure 4: the nodal points on the curve, and their coordinates against the distance from the base."""
    node_mm, covariance = shape.nodes(nodes.arc_mm)
    sigma_mm = np.sqrt(np.trace(covariance, axis1=1, axis2=2))
    with picture(path, 9.4, 4.6) as figure:
        grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1))
        axes = robot_axes(figure, grid[:, 0], shape.centreline.points_mm)
        axes.plot(*shape.centreline.points_mm.T, color=MEASURED)
        axes.scatter(*node_mm.T, color=NODE, s=28, depthshade=False)
        for name, arc, place in zip(nodes.names, nodes.arc_mm, node_mm, strict=True):
            axes.text(*place, f"   {name}, {arc:g} mm", fontsize=8)
        axes.set_title(f"Nodal points, standard deviation at most {1000 * sigma_mm.max():.0f} µm")
        for row, axis in enumerate("xyz"):
            along = figure.add_subplot(grid[row, 1])
            along.plot(shape.centreline.arc_mm, shape.centreline.points_mm[:, row], color=MEASURED)
            along.plot(nodes.arc_mm, node_mm[:, row], "o", color=NODE, markersize=5)
            along.set_ylabel(f"{axis}, mm")
        along.set_xlabel("distance from the base along the centreline, mm")
    return path


def _stages(path: Path, views: Sequence[View], shape: Shape, nodes: NodalPoints) -> Path:
    """Figure 6: source, segmented, skeleton and detected, a row for each camera."""
    node_mm, _ = shape.nodes(nodes.arc_mm)
    with picture(path, 10.0, 3.5 * len(views)) as figure:
        grid = figure.subplots(len(views), 4, squeeze=False)
        for row, view in zip(grid, views, strict=True):
            name = view.calibration.camera
            _camera_axes(row[0], view, f"{name}: source")
            silhouette = shape.stages.silhouettes[name] if shape.stages else None
            if silhouette:
                size = view.picture.shape[1::-1]
                mask = cv2.resize(
                    np.uint8(255) * (silhouette.mask > 0), size, interpolation=cv2.INTER_NEAREST
                )
                _camera_axes(row[1], view, "segmented", np.asarray(mask, np.uint8))
                _camera_axes(row[2], view, "skeleton", np.asarray(mask // 4, np.uint8))
                row[2].plot(*silhouette.skeleton.T, ".", color="white", markersize=1.2)
            _camera_axes(row[3], view, "detected")
            row[3].plot(
                *projected(view.calibration, shape.centreline.points_mm).T, color="#58c8ff", linewidth=1.2
            )
            places = projected(view.calibration, node_mm)
            row[3].plot(*places.T, "o", color=NODE, markeredgecolor="white", markersize=6)
            for label, (x, y) in zip(nodes.names, places, strict=True):
                row[3].annotate(label, (x, y), (9, -3), textcoords="offset points", fontsize=8, color="white")
    return path


def _camera_axes(axes: Any, view: View, title: str, source: NDArray[np.uint8] | None = None) -> Any:
    part, extent = view.shown(view.picture if source is None else source)
    axes.imshow(part, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axes.set(title=title, xticks=(), yticks=(), xlim=extent[:2], ylim=extent[2:])
    axes.spines[:].set_visible(False)
    axes.grid(visible=False)
    return axes
