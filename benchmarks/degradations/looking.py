"""What an outcome looks like: in words, and drawn over the pictures that it came from."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.degradations.level import Level
from benchmarks.degradations.rigs import project
from benchmarks.degradations.running import Outcome, Seen
from benchmarks.degradations.scenery import Image
from benchmarks.poses import NODES_MM, Array, true_nodes
from messaging.frames import CameraCalibration
from nodal.calibration_file import save_rig

TRUTH, FOUND = (60, 220, 60), (60, 60, 255)
FINER, MARGIN_PX = 2, 60


def in_words(outcome: Outcome) -> str:
    """One line about an outcome."""
    if outcome.refusal:
        return f"({outcome.start}): refused: {outcome.refusal}"
    return (
        f"({outcome.start}): nodal points off by {outcome.error_mm.mean():.3f} mm, "
        f"at most {outcome.error_mm.max():.3f}; flags: {', '.join(outcome.flags) or 'none'}"
    )


def errors_in_words(outcomes: Sequence[Outcome]) -> str:
    """By how much, at most, nodal points are off in each outcome that is silently wrong."""
    silent = [f"{outcome.start} {outcome.error_mm.max():.2f}" for outcome in outcomes if outcome.silent]
    return f"off by mm: {', '.join(silent)}"


def draw(folder: Path, level: Level, seen: Seen) -> None:
    """Into a folder, which is made: coded pictures, the calibration that sensing had, and what it found in each picture.

    The truth is green and broad, the shape red and fine, with a mark at each nodal point.
    """
    folder.mkdir(parents=True, exist_ok=True)
    believed = level.believed(level.bench.rig)
    save_rig(folder / "rig.json", believed)
    for true, taken_for in zip(level.bench.rig, believed, strict=True):
        data = seen.pictures.get(true.camera, b"")
        (folder / f"{true.camera}.picture").write_bytes(data)
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
        if picture is not None:
            cv2.imwrite(
                str(folder / f"{true.camera}.png"),
                _drawn(np.asarray(picture, np.uint8), true, taken_for, seen),
            )


def _drawn(picture: Image, true: CameraCalibration, taken_for: CameraCalibration, seen: Seen) -> Image:
    """The part of a picture in which the robot is, or should be, with both lines."""
    large = np.asarray(
        cv2.resize(picture, None, fx=FINER, fy=FINER, interpolation=cv2.INTER_NEAREST), np.uint8
    )
    lines = [(TRUTH, 3, project(true, seen.truth_mm), project(true, true_nodes(seen.truth_mm)))]
    if seen.shape is not None:
        found_mm, nodes_mm = seen.shape.centreline.points_mm, seen.shape.nodes(NODES_MM)[0]
        lines.append((FOUND, 1, project(taken_for, found_mm), project(taken_for, nodes_mm)))
    for colour, width, line, nodes in lines:
        cv2.polylines(large, [_fine(line)], False, colour, width, cv2.LINE_AA, shift=4)
        for node in _fine(nodes):
            cv2.circle(large, tuple(node.tolist()), 16 * 4, colour, width, cv2.LINE_AA, shift=4)
    shown = np.vstack([line for _, _, line, _ in lines])
    size = np.array(picture.shape[1::-1])
    left, top = (FINER * np.clip(shown.min(axis=0) - MARGIN_PX, 0, size - 2 * MARGIN_PX)).astype(int)
    right, bottom = (FINER * np.clip(shown.max(axis=0) + MARGIN_PX, 2 * MARGIN_PX, size)).astype(int)
    return large[top:bottom, left:right]


def _fine(pixels: Array) -> NDArray[np.int32]:
    """Pixels (n, 2) of the picture in sixteenths of those of the larger one."""
    fine: NDArray[np.int32] = np.rint(16 * (FINER * (pixels + 0.5) - 0.5)).clip(-1e6, 1e6).astype(np.int32)
    return fine
