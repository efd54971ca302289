"""Work areas: polygons in px, by camera, outside of which nothing is robot."""

from collections.abc import Iterator, Mapping

import cv2
import numpy as np

from messaging.checked import FloatArray
from messaging.frames import CameraCalibration
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image

LEAST_CORNERS = 3


def work_area_faults(
    areas: Mapping[str, FloatArray], calibrations: tuple[CameraCalibration, ...]
) -> Iterator[str]:
    """What is wrong with work areas, corners (n, 2) in px by camera, for these cameras; each begins with its key."""
    cameras = {calibration.camera: Camera(calibration) for calibration in calibrations}
    for name, corners in areas.items():
        if name not in cameras:
            yield f"work_area.{name} is not one of the cameras {', '.join(cameras)}"
        elif fault := _fault(corners, cameras[name]):
            yield f"work_area.{name} {fault}"


def work_area_mask(corners: FloatArray, grid: Grid) -> Image:
    """The detection pixels (h, w) in a work area (255) and outside of it (0)."""
    mask = np.zeros(grid.shape, dtype=np.uint8)
    cv2.fillPoly(mask, [np.rint(grid.coarse(corners) * 16).astype(np.int32)], 255, shift=4)
    return mask


def _fault(corners: FloatArray, camera: Camera) -> str:
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < LEAST_CORNERS:
        return f"has the shape {corners.shape}; a polygon is {LEAST_CORNERS} corners [x, y] or more"
    width, height = camera.size_px
    inside = ((corners >= -1) & (corners <= [width, height])).all(axis=1)
    if not inside.all():
        x, y = corners[~inside][0]
        return f"has a corner [{x:g}, {y:g}] outside of the picture, which is {width}x{height} px"
    x, y = camera.project(np.zeros((1, 3)))[0]
    if cv2.pointPolygonTest(corners.astype(np.float32), (float(x), float(y)), measureDist=False) < 0:
        return f"does not contain the robot's base, which the camera sees at [{x:.0f}, {y:.0f}] px"
    return ""
