"""A shape from still images: read the files, estimate without a prior. `still_words` says what came out."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from messaging.frames import CameraCalibration
from messaging.shape import NodalPoints
from nodal.calibration_file import load_rig
from nodal.errors import CommandError
from sensing.errors import RefusedError, UnreadableImageError
from sensing.method import METHODS, Method
from sensing.pictures.work_area import work_area_faults
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape

Corners = tuple[tuple[float, float], ...]
BRIGHTEST = 255
LARGEST_DISTANCE = 442
"""Between black and white, in equation 1's levels."""


@dataclass(frozen=True, kw_only=True)
class Question:
    """What the user gave: files by camera name, nodal points in mm from the base, the robot's length if known.

    `colour_rgb` is the backdrop's where a camera has no background, `threshold` equation 1's T in levels, `work_areas` are
    polygons' corners in px by camera; without them sensing finds its own.
    """

    calibration: Path
    images: Mapping[str, Path]
    backgrounds: Mapping[str, Path]
    nodes_mm: tuple[float, ...]
    length_mm: float | None
    method: MethodName = MethodName.REFINED
    colour_rgb: tuple[float, float, float] | None = None
    threshold: float | None = None
    work_areas: Mapping[str, Corners] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The shape with its nodal points: positions (n, 3) in mm and worst standard deviations (n,) in mm."""

    method: Method
    shape: Shape
    points: NodalPoints
    node_mm: NDArray[np.float64]
    sigma_mm: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Refusal:
    """Why there is no shape in these pictures of a scene."""

    scene: Scene
    reason: str


def answer(question: Question) -> Answer | Refusal:
    """Estimate; raises NodalError for files and arguments that cannot be used, refuses pictures that show no shape."""
    rig = _cameras(question)
    points = NodalPoints(
        names=tuple(f"{arc:g}" for arc in question.nodes_mm), arc_mm=np.array(question.nodes_mm)
    )
    _check(question, rig)
    scene = _scene(question, rig, {})
    try:
        scene = _scene(question, rig, _read(question.backgrounds))
        method = METHODS[question.method](scene)
        pictures = {name: scene.picture(name, data) for name, data in _read(question.images).items()}
        shape = method.estimate(pictures, 0.0, None, time.perf_counter)
    except (RefusedError, UnreadableImageError) as error:
        return Refusal(scene=scene, reason=str(error))
    node_mm, covariance = shape.nodes(points.arc_mm)
    sigma_mm = np.sqrt(np.linalg.eigvalsh(covariance)[:, -1])
    return Answer(method=method, shape=shape, points=points, node_mm=node_mm, sigma_mm=sigma_mm)


def draw(question: Question, found: Answer | Refusal, folder: Path) -> None:
    """Pictures that explain what was found into `folder`, which is made; raises CommandError when that cannot be."""
    from nodal.report.pictures.estimate.writing import draw_estimate, draw_refusal  # noqa: PLC0415  an extra

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f"--figures {folder}: cannot be made: {error.strerror}") from error
    jpegs = _read(question.images)
    if isinstance(found, Answer):
        draw_estimate(folder, found.method, jpegs, found.shape, found.points)
    else:
        draw_refusal(folder, found.scene, jpegs, 0.0, found.reason)


def _scene(question: Question, rig: tuple[CameraCalibration, ...], backgrounds: Mapping[str, bytes]) -> Scene:
    return Scene.of(
        rig,
        backgrounds=backgrounds,
        colour_rgb=question.colour_rgb,
        length_mm=question.length_mm,
        work_areas={name: np.array(corners) for name, corners in question.work_areas.items()},
        threshold=question.threshold,
    )


def _check(question: Question, rig: tuple[CameraCalibration, ...]) -> None:
    """Refuse numbers that nothing can be estimated with; comparisons are such that NaN fails them."""
    length, threshold, colour = question.length_mm, question.threshold, question.colour_rgb
    if length is not None and not (math.isfinite(length) and length > 0):
        raise CommandError(f"--length {length:g} mm is not a length; it must be above 0")
    if threshold is not None and not 0 < threshold <= LARGEST_DISTANCE:
        raise CommandError(
            f"--threshold {threshold:g} is not a colour distance; above 0 and up to {LARGEST_DISTANCE} levels are"
        )
    if colour is not None and not all(0 <= level <= BRIGHTEST for level in colour):
        words = ",".join(f"{level:g}" for level in colour)
        raise CommandError(f"--colour {words} is not a colour; each of R, G and B is 0 to {BRIGHTEST}")
    areas = {name: np.array(corners) for name, corners in question.work_areas.items()}
    for fault in work_area_faults(areas, rig):
        raise CommandError(f"--work-area {fault.removeprefix('work_area.')}")


def _cameras(question: Question) -> tuple[CameraCalibration, ...]:
    rig = load_rig(question.calibration)
    known = {camera.camera for camera in rig}
    for option, given in (
        ("--image", question.images),
        ("--background", question.backgrounds),
        ("--work-area", question.work_areas),
    ):
        for name in given:
            if name not in known:
                raise CommandError(
                    f"{option} {name}=...: the calibration has no camera {name!r}, only {sorted(known)}"
                )
    if len(question.images) < 2:
        raise CommandError(
            f"--image is given for {sorted(question.images)} only; a shape takes two cameras or more"
        )
    return tuple(camera for camera in rig if camera.camera in question.images)


def _read(files: Mapping[str, Path]) -> dict[str, bytes]:
    try:
        return {name: file.read_bytes() for name, file in files.items()}
    except OSError as error:
        raise CommandError(f"{error.filename}: cannot be read: {error.strerror}") from error
