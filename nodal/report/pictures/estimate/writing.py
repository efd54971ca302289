"""Writes the pictures of an estimate, or of a refusal."""

from collections.abc import Mapping
from pathlib import Path

from messaging.shape import NodalPoints
from nodal.report.pictures.estimate.along import draw_along
from nodal.report.pictures.estimate.cameras import draw_cameras
from nodal.report.pictures.estimate.refusal import draw_refused
from nodal.report.pictures.estimate.space import draw_space
from nodal.report.pictures.estimate.subject import Subject
from sensing.method import Method
from sensing.scene import Scene
from sensing.shape import Shape

CAMERAS, SPACE, ALONG, REFUSED = "estimate-cameras", "estimate-space", "estimate-along", "estimate-refused"


def draw_estimate(
    folder: Path, method: Method, jpegs: Mapping[str, bytes], shape: Shape, nodes: NodalPoints
) -> list[Path]:
    """A shape that this method found in these coded pictures, in three figures; returns the files.

    Raises NodalPointError for a point that is not on the robot, ReportError when no picture can be shown, NodalError
    without matplotlib.
    """
    subject = Subject(method, jpegs, shape, nodes)
    written: list[Path] = []
    draw_cameras(folder / CAMERAS, subject, written)
    draw_space(folder / SPACE, subject, written)
    draw_along(folder / ALONG, subject, written)
    return written


def draw_refusal(
    folder: Path, scene: Scene, jpegs: Mapping[str, bytes], insertion_mm: float, reason: str
) -> list[Path]:
    """Why a method found no shape in this scene's coded pictures, in one figure; returns the files.

    Raises NodalError without matplotlib.
    """
    written: list[Path] = []
    draw_refused(folder / REFUSED, scene, jpegs, insertion_mm, reason, written)
    return written
