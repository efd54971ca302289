"""What a camera sees, as pictures need it: decoded, projected, cropped around the robot."""

import dataclasses

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.frames import CameraCalibration
from nodal.errors import ReportError

Array = NDArray[np.float64]

MARGIN_PX = 70
NARROWEST = 0.72
"""Least width over height of a part, so that parts of a straight and a bent robot look alike."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class View:
    """One camera's picture (H, W, 3) in RGB, with the part (x0, y0, x1, y1) in px that shows the robot."""

    calibration: CameraCalibration
    picture: NDArray[np.uint8]
    part: tuple[int, int, int, int]

    @classmethod
    def around(cls, calibration: CameraCalibration, jpeg: bytes, points_mm: Array) -> "View":
        """The view of this picture, with the part around points (N, 3) of the robot; raises ReportError."""
        picture = decoded(calibration.camera, jpeg)
        seen = projected(calibration, points_mm)
        (x0, y0), (x1, y1) = seen.min(axis=0) - MARGIN_PX, seen.max(axis=0) + MARGIN_PX
        wanting = max(NARROWEST * (y1 - y0) - (x1 - x0), 0) / 2
        x0, x1 = x0 - wanting, x1 + wanting
        height, width = picture.shape[:2]
        part = int(max(x0, 0)), int(max(y0, 0)), int(min(x1, width)), int(min(y1, height))
        if part[2] <= part[0] or part[3] <= part[1]:
            # the points are out of this camera's view
            part = 0, 0, width, height
        return cls(calibration=calibration, picture=picture, part=part)

    def shown(
        self, picture: NDArray[np.uint8]
    ) -> tuple[NDArray[np.uint8], tuple[float, float, float, float]]:
        """The part of a picture of full size, and its extent for `imshow`, so that overlays keep full-size pixels."""
        x0, y0, x1, y1 = self.part
        return picture[y0:y1, x0:x1], (x0 - 0.5, x1 - 0.5, y1 - 0.5, y0 - 0.5)


def decoded(camera: str, jpeg: bytes) -> NDArray[np.uint8]:
    """The picture (H, W, 3) in RGB; raises ReportError when it is none."""
    colour = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) if jpeg else None
    if colour is None:
        raise ReportError(f"camera {camera}: {len(jpeg)} bytes are not a picture that can be decoded")
    return np.asarray(cv2.cvtColor(colour, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def projected(calibration: CameraCalibration, points_mm: Array) -> Array:
    """Pixels (N, 2) of points (N, 3) in the robot frame, lens distortion included."""
    rotation, _ = cv2.Rodrigues(calibration.camera_from_robot[:3, :3])
    pixels, _ = cv2.projectPoints(
        points_mm.reshape(-1, 1, 3),
        rotation,
        calibration.camera_from_robot[:3, 3],
        calibration.intrinsics,
        calibration.distortion,
    )
    return np.asarray(pixels, np.float64).reshape(-1, 2)
