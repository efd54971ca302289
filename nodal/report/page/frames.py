"""What the cameras saw at telling moments, with the estimate drawn over it."""

from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from messaging.frames import Frame
from nodal.errors import ReportError
from nodal.report.findings import Findings
from nodal.report.loading import frame_set
from nodal.report.moments import Moment, telling_moments
from nodal.report.page.markup import element, figure
from nodal.report.page.numbers import with_unit
from nodal.report.page.overlaid import picture_svg
from nodal.report.pictures.views import View, decoded
from recordings import Log
from sensing.geometry.camera import Camera

Array = NDArray[np.float64]

STROKE = 1 / 160
"""Widths and sizes over a picture are shares of its height."""


def moment_pictures(log: Log, findings: Findings) -> list[Element]:
    """A figure for each moment of which there are frames."""
    figures = []
    for moment in telling_moments(findings):
        frames = frame_set(log, moment.shape.capture_time_ns)
        if frames:
            figures.append(_figure(moment, frames, findings))
    return figures


def _figure(moment: Moment, frames: dict[str, Frame], findings: Findings) -> Element:
    rig = {calibration.camera: Camera(calibration) for calibration in findings.run.rig}
    around_mm = _where(moment, findings)
    views = [_view(frame, rig.get(name), around_mm, moment) for name, frame in sorted(frames.items())]
    when = with_unit(findings.second(moment.shape.capture_time_ns), "s")
    titles = "; ".join(moment.titles)
    return figure(
        element("div", views, class_="views"),
        [element("strong", f"{when}: "), titles],
    )


def _where(moment: Moment, findings: Findings) -> Array | None:
    """Points (N, 3) of the robot then, or of where it was last known to be; None when it never was."""
    if moment.shape.centreline_mm.size:
        return moment.shape.centreline_mm
    usable = findings.run.usable
    before = [s for s in usable if s.capture_time_ns <= moment.shape.capture_time_ns] or usable[:1]
    return before[-1].centreline_mm if before else None


def _view(frame: Frame, camera: Camera | None, around_mm: Array | None, moment: Moment) -> Element:
    try:
        if camera is None or around_mm is None:
            return picture_svg(decoded(frame.camera, frame.jpeg), f"camera {frame.camera}")
        view = View.around(camera, frame.jpeg, around_mm)
    except ReportError as error:
        return element("p", str(error))
    overlay = _overlay(camera, moment, view.part[3] - view.part[1])
    words = f"camera {frame.camera}" + (", with the estimated centreline and nodal points" if overlay else "")
    return picture_svg(view.picture, words, overlay, view.part)


def _overlay(camera: Camera, moment: Moment, height_px: int) -> list[Element]:
    """Centreline, nodal points with their names, and a cross where each should have been."""
    shape, width = moment.shape, height_px * STROKE
    marks = []
    if shape.centreline_mm.size:
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in camera.project(shape.centreline_mm))
        marks.append(element("polyline", points=points, class_="seen", stroke_width=f"{width:.2f}"))
    for x, y in camera.project(moment.asked_mm) if len(moment.asked_mm) else ():
        arm = 3 * width
        cross = f"M{x - arm:.1f},{y:.1f}h{2 * arm:.1f}M{x:.1f},{y - arm:.1f}v{2 * arm:.1f}"
        marks.append(element("path", d=cross, class_="wanted", stroke_width=f"{width:.2f}"))
    nodes = camera.project(shape.node_mm) if shape.node_names else ()
    for name, (x, y) in zip(shape.node_names, nodes, strict=True):
        place = {"cx": f"{x:.1f}", "cy": f"{y:.1f}"}
        marks.append(
            element("circle", **place, r=f"{1.6 * width:.2f}", class_="node", stroke_width=f"{width / 3:.2f}")
        )
        marks.append(
            element(
                "text",
                name,
                x=f"{x + 4 * width:.1f}",
                y=f"{y:.1f}",
                font_size=f"{5.5 * width:.1f}",
                stroke_width=f"{width:.2f}",
            )
        )
    return marks
