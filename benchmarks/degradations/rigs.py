"""Cameras: where they stand, how they are built, and how a calibration may be wrong about that."""

import cv2
import numpy as np

from benchmarks.poses import Array
from drivers.simulated.cameras.rig import default_cameras
from messaging.frames import CameraCalibration

Rig = tuple[CameraCalibration, ...]

LOOKS_AT_MM = np.array([0.0, 0.0, 30.0])


def standing(
    camera: CameraCalibration,
    name: str,
    azimuth_deg: float,
    distance_mm: float = 195.0,
    height_mm: float = 58.0,
) -> CameraCalibration:
    """The same camera put elsewhere about the robot; azimuth 0 is the robot's -Y side."""
    azimuth = np.deg2rad(azimuth_deg)
    place = np.array([distance_mm * np.sin(azimuth), -distance_mm * np.cos(azimuth), height_mm])
    forward = (LOOKS_AT_MM - place) / np.linalg.norm(LOOKS_AT_MM - place)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return _changed(camera, name=name, pose=_pose(rotation, -rotation @ place))


def apart(angle_deg: float) -> Rig:
    """The reference cameras, with this angle between them."""
    left, right = default_cameras()
    return standing(left, "left", -angle_deg / 2), standing(right, "right", angle_deg / 2)


def away(distance_mm: float) -> Rig:
    """The reference cameras this far from the robot."""
    left, right = default_cameras()
    return (
        standing(left, "left", -30.5, distance_mm, 58 / 195 * distance_mm),
        standing(right, "right", 29.5, distance_mm, 58 / 195 * distance_mm),
    )


def several(count: int) -> Rig:
    """The reference cameras and, up to four in all, one from above and one from the side."""
    left, right = default_cameras()
    more = standing(left, "above", 0.0, 190.0, 118.0), standing(right, "side", 75.0, 200.0, 40.0)
    return left, right, *more[: count - 2]


def sized(width_px: int, height_px: int) -> Rig:
    """The reference cameras with other sensors behind the same lenses; what is too wide is cut off."""
    factor = height_px / 1080
    rig = []
    for camera in default_cameras():
        intrinsics = camera.intrinsics.copy()
        intrinsics[:2] *= factor
        intrinsics[:2, 2] += 0.5 * factor - 0.5
        intrinsics[0, 2] += (width_px - factor * camera.width_px) / 2
        rig.append(_changed(camera, intrinsics=intrinsics, size_px=(width_px, height_px)))
    return tuple(rig)


def smaller(camera: CameraCalibration, factor: int) -> CameraCalibration:
    """The same camera with fewer, larger pixels; integer coordinates stay pixel centres."""
    intrinsics = camera.intrinsics.copy()
    intrinsics[:2] /= factor
    intrinsics[:2, 2] += 0.5 / factor - 0.5
    size = camera.width_px // factor, camera.height_px // factor
    return _changed(camera, intrinsics=intrinsics, size_px=size)


def aside(right_px: float, down_px: float, cameras: tuple[str, ...] = ("left", "right")) -> Rig:
    """The reference cameras with sensors moved so that what they see lies that much further right and down."""
    return tuple(
        _changed(camera, intrinsics=camera.intrinsics + _centre(right_px, down_px))
        if camera.camera in cameras
        else camera
        for camera in default_cameras()
    )


def turned(
    camera: CameraCalibration, axis: tuple[float, float, float], angle_rad: float
) -> CameraCalibration:
    """The camera turned about an axis of its own frame: x right, y down, z along its view."""
    turn = cv2.Rodrigues(angle_rad * np.array(axis))[0]
    pose = camera.camera_from_robot
    return _changed(camera, pose=_pose(turn @ pose[:3, :3], turn @ pose[:3, 3]))


def moved(camera: CameraCalibration, by_mm: Array) -> CameraCalibration:
    """The camera moved by (3,) along the axes of its own frame."""
    pose = camera.camera_from_robot.copy()
    pose[:3, 3] -= by_mm
    return _changed(camera, pose=pose)


def zoomed(camera: CameraCalibration, factor: float) -> CameraCalibration:
    """The camera with another focal length."""
    intrinsics = camera.intrinsics.copy()
    intrinsics[[0, 1], [0, 1]] *= factor
    return _changed(camera, intrinsics=intrinsics)


def undistorted(camera: CameraCalibration) -> CameraCalibration:
    """The camera with a lens that does not distort."""
    return _changed(camera, distortion=np.zeros(5))


def project(camera: CameraCalibration, points_mm: Array) -> Array:
    """Where a camera sees points (n, 3): pixels (n, 2)."""
    pose = camera.camera_from_robot
    turn = cv2.Rodrigues(pose[:3, :3])[0]
    seen = cv2.projectPoints(points_mm, turn, pose[:3, 3], camera.intrinsics, camera.distortion)[0]
    return np.asarray(seen[:, 0], dtype=np.float64)


def _centre(right_px: float, down_px: float) -> Array:
    change = np.zeros((3, 3))
    change[:2, 2] = right_px, down_px
    return change


def _pose(rotation: Array, translation_mm: Array) -> Array:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation_mm
    return pose


def _changed(
    camera: CameraCalibration,
    *,
    name: str | None = None,
    size_px: tuple[int, int] | None = None,
    intrinsics: Array | None = None,
    distortion: Array | None = None,
    pose: Array | None = None,
) -> CameraCalibration:
    width, height = size_px or (camera.width_px, camera.height_px)
    return CameraCalibration(
        camera=name or camera.camera,
        width_px=width,
        height_px=height,
        intrinsics=camera.intrinsics if intrinsics is None else intrinsics,
        distortion=camera.distortion if distortion is None else distortion,
        camera_from_robot=camera.camera_from_robot if pose is None else pose,
    )
