"""A calibration held against cameras that are known exactly."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from benchmarks.poses import Array
from calibration.board import Board
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.corners import Corners
from calibration.projection import INTRINSICS, POSE, transformed
from messaging.frames import CameraCalibration

DISTANCE_MM = 190.0
"""Where the robot stands before the cameras."""
GRID = 24
Z_LIMIT = 1.96


def errors_and_sigmas(found: CalibratedCamera, true: CalibratedCamera) -> dict[str, tuple[float, float]]:
    """Each parameter that was estimated: how far from the truth, and its standard deviation."""
    numbers, exact = (
        np.concatenate([np.array(one.intrinsics)[[0, 1, 0, 1], [0, 1, 2, 2]], one.distortion])
        for one in (found, true)
    )
    pose, exact_pose = np.array(found.camera_from_rig), np.array(true.camera_from_rig)
    turn, _ = cv2.Rodrigues(pose[:3, :3] @ exact_pose[:3, :3].T)
    errors = np.concatenate([numbers - exact, turn.ravel(), pose[:3, 3] - exact_pose[:3, 3]])
    named = dict(zip((*INTRINSICS, *POSE), map(float, errors), strict=True))
    return {name: (named[name], sigma) for name, sigma in found.sigma.items()}


def camera_lines(found: CameraSet, true: Sequence[CameraCalibration]) -> Iterator[str]:
    """What came out beside the truth, camera by camera."""
    exact = CameraSet.of_rig(true)
    z_scores: list[float] = []
    for one, known in zip(found.cameras, exact.cameras, strict=True):
        held_out = "none" if one.held_out_rms_px is None else f"{one.held_out_rms_px:.4f}"
        yield f"{one.name}: {one.views} views, reprojection {one.rms_px:.4f}, held out {held_out} px RMS"
        compared = errors_and_sigmas(one, known)
        for name, (error, sigma) in compared.items():
            yield f"  {name:<15} error {error:+.6f}  sigma {sigma:.6f}  z {error / sigma:+.2f}"
        z_scores.extend(error / sigma for error, sigma in compared.values())
        mean_px, most_px = bending_px(one, known)
        yield f"  rays of the picture: {mean_px:.4f} px off on average, {most_px:.4f} px at most"
    for one, known in zip(found.cameras[1:], exact.cameras[1:], strict=True):
        (baseline, angle), (exact_baseline, exact_angle) = _baseline(one), _baseline(known)
        yield (
            f"{found.cameras[0].name} to {one.name}: baseline {baseline:.4f} mm ({baseline - exact_baseline:+.4f}), "
            f"between the axes {angle:.4f} degrees ({angle - exact_angle:+.4f}), "
            f"{_apart_mm(one, known):.4f} mm off at {DISTANCE_MM:g} mm"
        )
    within = np.mean(np.abs(z_scores) < Z_LIMIT)
    yield f"truth within 95 % bounds: {100 * within:.0f} % of {len(z_scores)} parameters, RMS z {_rms(np.array(z_scores)):.2f}"
    shape = ", ".join(
        f"{name.removesuffix('_mm')} {1e3 * amount:+.2f}" for name, amount in found.board_shape.items()
    )
    yield f"the board's shape, um and per mille: {shape}"
    if found.board_check is not None:
        check = found.board_check
        yield (
            f"the board in held-out views: {check.squares} sides, {1e3 * check.mean_error_mm:+.2f} um on average, "
            f"{1e3 * check.rms_error_mm:.2f} um RMS; corners {1e3 * check.surface_error_mm:.2f} um RMS off its surface"
        )


def bending_px(found: CalibratedCamera, true: CalibratedCamera) -> tuple[float, float]:
    """How far pixels all over the picture lie from where they truly belong, on average and at most.

    A turn of the whole camera is taken out: it is part of how the camera stands, not of how it sees.
    """
    across, down = np.meshgrid(
        np.linspace(0, true.width_px - 1, GRID), np.linspace(0, true.height_px - 1, GRID)
    )
    px = np.column_stack([across.ravel(), down.ravel()])
    rays, exact_rays = _rays(found, px), _rays(true, px)
    left, _, right = np.linalg.svd(rays.T @ exact_rays)
    apart = np.linalg.norm(rays @ left @ right - exact_rays, axis=1) * true.intrinsics[0][0]
    return float(apart.mean()), float(apart.max())


def corner_errors_px(
    board: Board, camera: CameraCalibration, robot_from_board: Array, corners: Corners
) -> Array:
    """Found minus true (n, 2)."""
    points_mm = transformed(robot_from_board, board.points_mm[corners.ids])
    pose = camera.camera_from_robot
    true_px, _ = cv2.projectPoints(
        points_mm, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], camera.intrinsics, camera.distortion
    )
    return np.asarray(corners.px - true_px.reshape(-1, 2))


def _rays(camera: CalibratedCamera, px: Array) -> Array:
    straight = cv2.undistortPoints(px, np.array(camera.intrinsics), np.array(camera.distortion)).reshape(
        -1, 2
    )
    ahead = np.column_stack([straight, np.ones(len(px))])
    return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True))


def _baseline(camera: CalibratedCamera) -> tuple[float, float]:
    """Its length in mm, and the angle in degrees between the optical axes."""
    pose = np.array(camera.camera_from_rig)
    return float(np.linalg.norm(pose[:3, 3])), float(np.degrees(np.arccos(pose[2, 2])))


def _apart_mm(found: CalibratedCamera, true: CalibratedCamera) -> float:
    """How far a point before the first camera is from where the other camera should see it."""
    point = np.array([0.0, 0.0, DISTANCE_MM, 1.0])
    return float(np.linalg.norm((np.array(found.camera_from_rig) - np.array(true.camera_from_rig)) @ point))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
