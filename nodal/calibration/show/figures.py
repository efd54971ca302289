"""What a calibration means in figures: how cameras see, how they stand, and how exactly they tell where something is. Pure."""

from itertools import combinations

import msgspec
import numpy as np

from calibration.camera_set import Array, CalibratedCamera
from messaging.frames import CameraCalibration
from nodal.calibration.formats.calibration import Calibration
from sensing.geometry.camera import Camera

MEASURED_PX = 0.1
"""How exactly sensing tells where the robot's middle is in one picture."""

Triple = tuple[float, float, float]
Pair = tuple[float, float]


class SeenCamera(msgspec.Struct, frozen=True, kw_only=True):
    """One camera. Lengths in mm, in the robot's frame or else the first camera's; `looks` is its viewing direction."""

    name: str
    size_px: tuple[int, int]
    focal_px: Pair
    field_of_view_deg: Pair
    """Across and down."""
    principal_point_px: Pair
    off_centre_px: Pair
    """The principal point from the middle of the picture."""
    corner_distortion_px: float
    """By how much the lens moves what lies in the picture's farthest corner."""
    position_mm: Triple
    looks: Triple
    distance_mm: float
    mm_per_px: float
    sigma: dict[str, float]
    views: int
    rms_px: float | None
    held_out_rms_px: float | None


class SeenPair(msgspec.Struct, frozen=True, kw_only=True):
    """Two cameras. `angle_deg` is that between their sights of the place looked at."""

    names: tuple[str, str]
    baseline_mm: float
    angle_deg: float
    across_mm: float
    """Standard deviation of a place across the mean sight, of MEASURED_PX in every picture."""
    depth_mm: float
    """The same along it."""


class Figures(msgspec.Struct, frozen=True, kw_only=True):
    """All of it. `frame` is `robot` or `rig`; `place_mm` is where distances, scales and accuracies are told for, `place` in words."""

    frame: str
    place: str
    place_mm: Triple
    cameras: tuple[SeenCamera, ...]
    pairs: tuple[SeenPair, ...]
    board_error_mm: float | None
    made_at: str


def figures(calibration: Calibration, robot_length_mm: float | None = None) -> Figures:
    """At the robot's middle, where the robot and its length are known; else where the optical axes come together."""
    known = calibration.rig_from_robot
    placed = calibration.cameras.in_robot_frame(np.eye(4) if known is None else known)
    cameras = tuple(map(Camera, placed))
    if known is None or robot_length_mm is None:
        place, place_mm = "where the cameras' axes come together", _meeting_place(cameras)
    else:
        place, place_mm = "at the robot's middle", np.array([0.0, 0.0, robot_length_mm / 2])
    check = calibration.cameras.board_check
    return Figures(
        frame="rig" if known is None else "robot",
        place=place,
        place_mm=_triple(place_mm),
        cameras=tuple(
            _camera(one, calibrated, camera, place_mm)
            for one, calibrated, camera in zip(calibration.cameras.cameras, placed, cameras, strict=True)
        ),
        pairs=tuple(_pair(one, other, place_mm) for one, other in combinations(cameras, 2)),
        board_error_mm=None if check is None else check.rms_error_mm,
        made_at=calibration.cameras.made_at,
    )


def _camera(one: CalibratedCamera, placed: CameraCalibration, camera: Camera, place_mm: Array) -> SeenCamera:
    width, height = camera.size_px
    (fx, _, cx), (_, fy, cy), _ = one.intrinsics
    corners = np.array([[x, y] for x in (0.0, width - 1.0) for y in (0.0, height - 1.0)])
    ideal = np.column_stack([(corners - [cx, cy]) / [fx, fy], np.ones(4)])
    seen = camera.project((ideal - placed.camera_from_robot[:3, 3]) @ camera.rotation)
    return SeenCamera(
        name=one.name,
        size_px=camera.size_px,
        focal_px=(fx, fy),
        field_of_view_deg=(_angle_deg(width, fx), _angle_deg(height, fy)),
        principal_point_px=(cx, cy),
        off_centre_px=(cx - (width - 1) / 2, cy - (height - 1) / 2),
        corner_distortion_px=float(np.linalg.norm(seen - corners, axis=1).max()),
        position_mm=_triple(camera.centre_mm),
        looks=_triple(camera.rotation[2]),
        distance_mm=float(np.linalg.norm(place_mm - camera.centre_mm)),
        mm_per_px=1.0 / float(camera.px_per_mm(place_mm[None])[0]),
        sigma=one.sigma,
        views=one.views,
        rms_px=one.rms_px,
        held_out_rms_px=one.held_out_rms_px,
    )


def _pair(one: Camera, other: Camera, place_mm: Array) -> SeenPair:
    sights = np.array([place_mm - one.centre_mm, place_mm - other.centre_mm])
    sights /= np.linalg.norm(sights, axis=1, keepdims=True)
    rows = np.vstack([camera.project_with_jacobian(place_mm[None])[1][0] for camera in (one, other)])
    covariance = MEASURED_PX**2 * np.linalg.pinv(rows.T @ rows)
    depth = sights.sum(axis=0) / np.linalg.norm(sights.sum(axis=0))
    along = float(depth @ covariance @ depth)
    return SeenPair(
        names=(one.name, other.name),
        baseline_mm=float(np.linalg.norm(one.centre_mm - other.centre_mm)),
        angle_deg=float(np.degrees(np.arccos(np.clip(sights[0] @ sights[1], -1, 1)))),
        across_mm=float(np.sqrt((np.trace(covariance) - along) / 2)),
        depth_mm=float(np.sqrt(along)),
    )


def _meeting_place(cameras: tuple[Camera, ...]) -> Array:
    """The point (3,) nearest to all optical axes, by least squares; for parallel axes it is anywhere along them."""
    across = [np.eye(3) - np.outer(camera.rotation[2], camera.rotation[2]) for camera in cameras]
    right = sum(matrix @ camera.centre_mm for matrix, camera in zip(across, cameras, strict=True))
    return np.asarray(np.linalg.lstsq(np.sum(across, axis=0), right, rcond=None)[0])


def _angle_deg(pixels: int, focal_px: float) -> float:
    return float(np.degrees(2 * np.arctan(pixels / 2 / focal_px)))


def _triple(values: Array) -> Triple:
    x, y, z = (float(value) for value in values)
    return x, y, z
