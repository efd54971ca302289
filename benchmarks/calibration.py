"""Cameras calibrated by our own tool against what they truly are: `python -m benchmarks.calibration [--photographs FOLDER]`.

Rendered boards of the simulated bench, and the board pictures of a folder of photographs with exact truth where one is given or
named by NODAL_PHOTOGRAPHS. There the robot is looked at too, with the cameras found and with the true ones, so that it is
seen which part of the error of nodal points comes from the calibration.
"""

# ruff: noqa: E402  arithmetic has to be fixed before NumPy is loaded, as in the sensing process
from nodal.arithmetic import pin

pin()

import argparse
import json
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchmarks.calibration_truth import camera_lines, corner_errors_px
from benchmarks.photographs import photographed_rig, photographs
from benchmarks.poses import Array, renderers
from benchmarks.scoring import Score
from benchmarks.sensing_costs import estimated
from benchmarks.yardstick import most_mm
from calibration.base_board import base_from_board
from calibration.board import Board
from calibration.camera_set import CameraSet
from calibration.corners import Corners, Picture
from calibration.solving import calibrate
from calibration.views import View, find_view
from drivers.simulated.cameras.projection import Lens
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.hands import HELD_S, MOVED_S, Hands
from messaging.board import BoardSettings
from messaging.frames import CameraCalibration
from sensing.method import METHODS
from sensing.scene import Scene
from sensing.settings import MethodName

HELD_NEAR_MM = np.array([0.0, 0.0, 40.0])
REFINED_PX = 5
"""Half of cornerSubPix's window in px: the largest that markers allow on the boards here."""
YARDSTICK_MM = 0.1

Rig = tuple[CameraCalibration, ...]


@dataclass(frozen=True)
class Shown:
    """Pictures (grey) of the board by camera, and where it truly was."""

    name: str
    pictures: Mapping[str, Picture]
    robot_from_board: Array


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--views", type=int, default=40, help="of the board on the simulated bench (default 40)"
    )
    parser.add_argument(
        "--photographs",
        type=Path,
        metavar="FOLDER",
        default=os.environ.get("NODAL_PHOTOGRAPHS"),
        help="photographs with exact truth (default: the folder that NODAL_PHOTOGRAPHS names, if any)",
    )
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    board, rig = Board(BoardSettings()), default_cameras()
    print(f"== {arguments.views} views of the board on the simulated bench")
    _calibrated(board, rig, list(_rendered(board, rig, arguments.views)))
    if arguments.photographs:
        _photographed(Path(arguments.photographs))


def _rendered(board: Board, rig: Rig, views: int) -> Iterator[Shown]:
    cameras, base_mm = renderers(rig), np.zeros(3)
    squares_mm = board.settings.square_mm * np.array(board.settings.squares)
    hands = Hands(squares_mm, [Lens(camera) for camera in rig], HELD_NEAR_MM, seed=1)
    for number in range(views):
        held = hands.at(number * (HELD_S + MOVED_S))
        pictures = {name: _grey(camera.render_board(base_mm, held, held)) for name, camera in cameras.items()}
        yield Shown(f"{number:02d}", pictures, held)


def _photographed(folder: Path) -> None:
    known = json.loads((folder / "calibration.json").read_text())
    printed, rig = known["charuco"], photographed_rig(folder)
    board = Board(
        BoardSettings(
            squares=tuple(printed["squares"]),
            square_mm=printed["square_mm"],
            marker_mm=printed["marker_mm"],
            dictionary=printed["dictionary"],
            legacy_pattern=printed["legacy_pattern"],
        )
    )
    poses = {name: np.array(pose) for name, pose in known["calib_views"].items()}
    shown = [Shown(name, _pictures(folder / "calib", name, rig), pose) for name, pose in poses.items()]
    print(f"\n== {len(shown)} photographs of the board from each camera")
    found = _calibrated(board, rig, shown)
    robot_from_board = np.array(known["registration"]["robot_from_board"])
    at_base = find_view(board, "at the base", _pictures(folder / "registration", "00", rig)).corners
    print("\n== the photographs of the robot, with these cameras and with the true ones")
    for name, cameras in _rigs(board, found, rig, at_base, robot_from_board).items():
        score = _looked_at(folder, cameras)
        print(name, *score.lines(), sep="\n", flush=True)
        print(most_mm(f"{name}: mean node error", float(score.error_mm.mean()), YARDSTICK_MM), flush=True)


def _calibrated(board: Board, rig: Rig, shown: Sequence[Shown]) -> CameraSet:
    """Find the corners, calibrate, and print what came of it."""
    began_s = time.perf_counter()
    views = [find_view(board, one.name, one.pictures) for one in shown]
    found_s = time.perf_counter()
    sizes = {camera.camera: (camera.width_px, camera.height_px) for camera in rig}
    cameras = calibrate(board, views, sizes).cameras
    solved_s = time.perf_counter()
    print(*_corner_lines(board, rig, shown, views), *camera_lines(cameras, rig), sep="\n")
    print(f"views left away: {cameras.views_rejected or 'none'}")
    pictures = len(shown) * len(rig)
    print(
        f"corners {(found_s - began_s) / pictures:.3f} s a picture, solved in {solved_s - found_s:.2f} s",
        flush=True,
    )
    return cameras


def _corner_lines(board: Board, rig: Rig, shown: Sequence[Shown], views: Sequence[View]) -> Iterator[str]:
    """The corners against the truth, beside what OpenCV's refinement by gradients makes of them."""
    ours, theirs = [], []
    for one, view in zip(shown, views, strict=True):
        for camera in rig:
            if camera.camera not in view.corners:
                continue
            corners = view.corners[camera.camera]
            gradients = _refined_by_gradients(one.pictures[camera.camera], corners)
            ours.append(corner_errors_px(board, camera, one.robot_from_board, corners))
            theirs.append(corner_errors_px(board, camera, one.robot_from_board, gradients))
    for name, errors in (("ours", ours), ("cornerSubPix", theirs)):
        px = np.concatenate(errors)
        yield f"corners, {name}: {np.sqrt(np.mean(px**2)):.4f} px RMS, bias {px[:, 0].mean():+.4f} {px[:, 1].mean():+.4f}"


def _refined_by_gradients(grey: Picture, corners: Corners) -> Corners:
    window, stop = (REFINED_PX, REFINED_PX), (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-3)
    start = corners.px.astype(np.float32).reshape(-1, 1, 2)
    px = cv2.cornerSubPix(grey, start, window, (-1, -1), stop)
    return Corners(corners.ids, px.reshape(-1, 2).astype(np.float64), corners.blur_px)


def _rigs(
    board: Board, found: CameraSet, true: Rig, at_base: Mapping[str, Corners], robot_from_board: Array
) -> dict[str, Rig]:
    """Cameras and the robot's place before them: both found, the latter alone, and both as they are."""

    def based(cameras: CameraSet) -> Rig:
        found_base = base_from_board(cameras, [at_base], board.points_mm, robot_from_board)
        return cameras.in_robot_frame(np.array(found_base.rig_from_robot))

    return {
        "cameras and base found": based(found),
        "cameras true, base found": based(CameraSet.of_rig(true)),
        "cameras and base true": true,
    }


def _looked_at(folder: Path, rig: Rig) -> Score:
    score = Score()
    for one in photographs(folder):
        method = METHODS[MethodName.REFINED](Scene.of(rig, backgrounds=one.backgrounds))
        score.add(lambda method=method, one=one: estimated(method, one.pictures), one.truth_mm)
    return score


def _pictures(folder: Path, name: str, rig: Rig) -> dict[str, Picture]:
    return {camera.camera: _grey((folder / f"{name}_{camera.camera}.jpg").read_bytes()) for camera in rig}


def _grey(jpeg: bytes) -> Picture:
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE), np.uint8)


if __name__ == "__main__":
    main()
