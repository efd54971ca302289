"""How far cameras stand from where they stood. Pure."""

from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import CalibratedCamera, CameraSet

Array = NDArray[np.float64]


class Moved(msgspec.Struct, frozen=True, kw_only=True):
    """A camera that stands elsewhere, told in the first camera's frame."""

    camera: str
    shift_mm: float
    turn_deg: float


def moved(before: CameraSet | None, now: CameraSet) -> Iterator[Moved]:
    """Every camera but the first, as far as it was known before."""
    earlier = {camera.name: camera for camera in before.cameras} if before else {}
    for camera in now.cameras[1:]:
        if camera.name in earlier:
            was = earlier[camera.name]
            change = np.array(camera.camera_from_rig) @ np.linalg.inv(np.array(was.camera_from_rig))
            turn = np.arccos(np.clip((np.trace(change[:3, :3]) - 1) / 2, -1, 1))
            yield Moved(
                camera=camera.name,
                shift_mm=float(np.linalg.norm(centre_mm(camera) - centre_mm(was))),
                turn_deg=float(np.degrees(turn)),
            )


def centre_mm(camera: CalibratedCamera) -> Array:
    """(3,) the camera's centre in the rig frame."""
    pose = np.array(camera.camera_from_rig)
    return np.asarray(-pose[:3, :3].T @ pose[:3, 3])
