"""A shape from still images: read the files, estimate without a prior, say what came out."""

import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from messaging.frames import CameraCalibration
from messaging.shape import NodalPoints
from nodal.calibration_file import load_rig
from nodal.errors import CommandError
from sensing.errors import RefusedError, UnreadableImageError
from sensing.method import METHODS, Method
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape


@dataclass(frozen=True, kw_only=True)
class Question:
    """What the user gave: files by camera name, nodal points in mm from the base, the robot's length if known."""

    calibration: Path
    images: Mapping[str, Path]
    backgrounds: Mapping[str, Path]
    nodes_mm: tuple[float, ...]
    length_mm: float | None
    method: MethodName = MethodName.REFINED


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
    if question.length_mm is not None and not (math.isfinite(question.length_mm) and question.length_mm > 0):
        raise CommandError(f"--length {question.length_mm:g} mm is not a length; it must be above 0")
    scene = Scene.of(rig, length_mm=question.length_mm)
    try:
        scene = Scene.of(rig, backgrounds=_read(question.backgrounds), length_mm=question.length_mm)
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


def as_json(found: Answer | Refusal) -> str:
    """One JSON object; lengths in mm, robot frame."""
    if isinstance(found, Refusal):
        return json.dumps({"refused": found.reason})
    shape = found.shape
    return json.dumps(
        {
            "nodes": [
                {"name": name, "arc_mm": float(arc), "position_mm": place.tolist(), "sigma_mm": float(sigma)}
                for name, arc, place, sigma in zip(
                    found.points.names, found.points.arc_mm, found.node_mm, found.sigma_mm, strict=True
                )
            ],
            "centreline_mm": shape.centreline.points_mm.tolist(),
            "length_mm": shape.length_mm,
            "ray_gap_mm": shape.evidence.ray_gap_mm,
            "flags": [str(flag) for flag in shape.flags],
            "stage_ms": {name: 1e3 * seconds for name, seconds in shape.stage_s.items()},
        }
    )


def as_text(found: Answer | Refusal) -> str:
    """A table for people."""
    if isinstance(found, Refusal):
        return f"refused: {found.reason}"
    shape = found.shape
    lines = ["node      arc mm        x mm        y mm        z mm    sigma mm"]
    lines += [
        f"{name:<8}{arc:8.2f}" + "".join(f"{value:12.3f}" for value in (*place, sigma))
        for name, arc, place, sigma in zip(
            found.points.names, found.points.arc_mm, found.node_mm, found.sigma_mm, strict=True
        )
    ]
    stages = ", ".join(f"{name} {1e3 * seconds:.0f}" for name, seconds in shape.stage_s.items())
    lines += [
        f"length {shape.length_mm:.2f} mm, mean ray gap {shape.evidence.ray_gap_mm:.3f} mm, residual {shape.residual_px:.2f} px",
        f"flags: {', '.join(shape.flags) or 'none'}",
        f"stages, ms: {stages}",
    ]
    return "\n".join(lines)


def _cameras(question: Question) -> tuple[CameraCalibration, ...]:
    rig = load_rig(question.calibration)
    known = {camera.camera for camera in rig}
    for option, files in (("--image", question.images), ("--background", question.backgrounds)):
        for name in files:
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
