"""The reference bench's two cameras, as a simulated bench has them."""

import numpy as np

from drivers.simulated.cameras.arrays import Array
from messaging.frames import CameraCalibration

_LOOKS_AT_MM = np.array([0.0, 0.0, 30.0])


def default_cameras() -> tuple[CameraCalibration, ...]:
    """Two cameras named left and right, 60 degrees apart about the robot, 195 mm away on its -Y side."""
    return (
        _camera("left", azimuth_deg=-30.5, focal_px=1440.0, centre_px=(967.0, 522.0), k1=0.078, k2=-0.165),
        _camera("right", azimuth_deg=29.5, focal_px=1436.0, centre_px=(949.0, 551.0), k1=0.069, k2=-0.152),
    )


def _camera(
    name: str, *, azimuth_deg: float, focal_px: float, centre_px: tuple[float, float], k1: float, k2: float
) -> CameraCalibration:
    azimuth = np.deg2rad(azimuth_deg)
    position_mm = np.array([195 * np.sin(azimuth), -195 * np.cos(azimuth), 58.0])
    rotation = _looking(_LOOKS_AT_MM - position_mm)
    camera_from_robot = np.eye(4)
    camera_from_robot[:3, :3] = rotation
    camera_from_robot[:3, 3] = -rotation @ position_mm
    return CameraCalibration(
        camera=name,
        width_px=1920,
        height_px=1080,
        intrinsics=np.array([[focal_px, 0, centre_px[0]], [0, focal_px + 1.2, centre_px[1]], [0, 0, 1]]),
        distortion=np.array([k1, k2, 0.0006, -0.0008, 0.027]),
        camera_from_robot=camera_from_robot,
    )


def _looking(direction: Array) -> Array:
    """(3, 3) camera_from_robot of a camera that looks along a direction, with the robot's +Z up in its picture."""
    forward = direction / np.linalg.norm(direction)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])
