"""By how much each lens moves what it shows."""

import numpy as np

from calibration.camera_set import CalibratedCamera
from calibration.projection import project
from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, figure, vector
from nodal.report.pictures.chart import NARROW_IN, page_svg
from nodal.report.pictures.style import DESIRED, MEASURED, NODE, drawing

TITLE = "Distortion"
ARROWS = 16, 9
FINE = 80, 45
LEAST_PX = 1e-6


def content(known: Material) -> Content:
    """A field of arrows for each camera."""
    return [
        element(
            "p",
            "From where a pinhole camera would show a point to where this lens shows it. Lines join places that are moved by the "
            "same number of pixels. The cross is the principal point.",
        ),
        element(
            "div",
            [
                figure(vector(_field(camera), f"Distortion of camera {camera.name}"), camera.name)
                for camera in known.cameras.cameras
            ],
            class_="charts",
        ),
    ]


def _field(camera: CalibratedCamera) -> str:
    height_in = NARROW_IN * camera.height_px / camera.width_px + 0.5
    with drawing(NARROW_IN, height_in, f"distortion-{camera.name}") as drawn:
        axes = drawn.subplots()
        x, y, moved = _moved_px(camera, FINE)
        levels = axes.contour(x, y, np.linalg.norm(moved, axis=2), levels=4, colors=DESIRED, linewidths=0.7)
        axes.clabel(levels, fontsize=7, fmt="%g px")
        x, y, moved = _moved_px(camera, ARROWS)
        longest = max(float(np.linalg.norm(moved, axis=2).max()), LEAST_PX)
        scale = longest * ARROWS[0] / camera.width_px
        axes.quiver(
            x,
            y,
            *np.moveaxis(moved, 2, 0),
            angles="xy",
            scale_units="xy",
            scale=scale,
            color=MEASURED,
            width=0.003,
        )
        axes.plot(camera.intrinsics[0][2], camera.intrinsics[1][2], "+", color=NODE, markersize=9)
        axes.set(
            xlim=(0, camera.width_px), ylim=(camera.height_px, 0), xlabel="px", ylabel="px", aspect="equal"
        )
        axes.grid(visible=False)
        return page_svg(drawn)


def _moved_px(camera: CalibratedCamera, steps: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grid over the picture, as x, y (rows, columns), and by how much (rows, columns, 2) it is moved."""
    (fx, _, cx), (_, fy, cy), _ = camera.intrinsics
    x, y = np.meshgrid(
        (np.arange(steps[0]) + 0.5) * camera.width_px / steps[0],
        (np.arange(steps[1]) + 0.5) * camera.height_px / steps[1],
    )
    points = np.column_stack([(x.ravel() - cx) / fx, (y.ravel() - cy) / fy, np.ones(x.size)])
    seen, _, _ = project(np.array([fx, fy, cx, cy, *camera.distortion]), points)
    return x, y, (seen - np.column_stack([x.ravel(), y.ravel()])).reshape(*x.shape, 2)
