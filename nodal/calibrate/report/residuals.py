"""How corners lie about where the solution has them: over all, and view by view."""

from typing import Any

import numpy as np

from nodal.calibrate.report.material import Material
from nodal.report.charts import Chart, line
from nodal.report.page.markup import Content, element, figure, vector
from nodal.report.page.run_page import drawn
from nodal.report.pictures.chart import WIDE_IN, page_svg
from nodal.report.pictures.style import PALETTE, drawing

TITLE = "Residuals"
BINS = 41
HIGH_IN = 2.6
BAR = 0.8


def content(known: Material) -> Content:
    """A histogram a coordinate, and bars a view."""
    if not known.kept.sightings:
        return None
    return [
        drawn([_histogram(known, axis) for axis in (0, 1)], "residuals"),
        element(
            "div",
            figure(vector(_bars(known), _bar_words(known)), "RMS of each view", wide=True),
            class_="charts",
        ),
    ]


def _histogram(known: Material, axis: int) -> Chart:
    residuals = {
        camera.name: np.concatenate([one.residual_px for one in known.kept.of_camera(camera.name)])[:, axis]
        for camera in known.cameras.cameras
        if known.kept.of_camera(camera.name)
    }
    reach = 4 * max(float(np.std(values)) for values in residuals.values())
    edges = np.linspace(-reach, reach, BINS)
    return Chart(
        key=f"histogram-{'xy'[axis]}",
        title=f"Found minus predicted, {('across', 'down')[axis]}",
        x_label="px",
        y_label="corners, %",
        series=tuple(
            line(name, edges, _shares(values, edges), number, "steps")
            for number, (name, values) in enumerate(residuals.items())
        ),
    )


def _shares(values: Any, edges: Any) -> Any:
    counts, _ = np.histogram(values, edges)
    return np.append(100 * counts / len(values), 0.0)


def _bars(known: Material) -> str:
    """One bar for each camera in each view."""
    views = list(known.kept.rig_from_board)
    cameras = known.cameras.cameras
    with drawing(WIDE_IN, HIGH_IN, "views") as drawn_figure:
        axes = drawn_figure.subplots()
        for number, camera in enumerate(cameras):
            of_view = {one.view: one.rms_px for one in known.kept.of_camera(camera.name)}
            places = np.arange(len(views)) + BAR * ((number + 0.5) / len(cameras) - 0.5)
            heights = [of_view.get(view, 0.0) for view in views]
            axes.bar(
                places, heights, BAR / len(cameras), color=PALETTE[number % len(PALETTE)], label=camera.name
            )
        axes.set_xticks(range(len(views)), views, fontsize=7)
        axes.set(xlabel="view", ylabel="px")
        axes.grid(visible=False, axis="x")
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=len(cameras), borderaxespad=0.2)
        return page_svg(drawn_figure)


def _bar_words(known: Material) -> str:
    worst = max(known.kept.sightings, key=lambda one: one.rms_px)
    return f"RMS of each view in each camera; the largest is {worst.rms_px:.3f} px, view {worst.view} in camera {worst.camera}"
