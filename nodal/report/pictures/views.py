"""What a camera sees, as pictures need it: decoded, projected, cropped around the robot."""

import dataclasses

import cv2
import numpy as np
from numpy.typing import NDArray

from nodal.errors import ReportError
from sensing.geometry.camera import Camera

Array = NDArray[np.float64]

AS_SENSED = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
MARGIN_PX = 70
NARROWEST = 0.72
"""Least width over height of a part, so that parts of a straight and a bent robot look alike."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class View:
    """One camera's picture (H, W, 3) in RGB, with the part (x0, y0, x1, y1) in px that shows the robot."""

    camera: Camera
    picture: NDArray[np.uint8]
    part: tuple[int, int, int, int]

    @classmethod
    def around(cls, camera: Camera, jpeg: bytes, points_mm: Array) -> "View":
        """The view of this picture, with the part around points (N, 3) of the robot; raises ReportError."""
        picture = decoded(camera.name, jpeg)
        seen = camera.project(points_mm)
        (x0, y0), (x1, y1) = seen.min(axis=0) - MARGIN_PX, seen.max(axis=0) + MARGIN_PX
        wanting = max(NARROWEST * (y1 - y0) - (x1 - x0), 0) / 2
        x0, x1 = x0 - wanting, x1 + wanting
        height, width = picture.shape[:2]
        part = int(max(x0, 0)), int(max(y0, 0)), int(min(x1, width)), int(min(y1, height))
        if part[2] <= part[0] or part[3] <= part[1]:
            # the points are out of this camera's view
            part = 0, 0, width, height
        return cls(camera=camera, picture=picture, part=part)

    def shown(
        self, picture: NDArray[np.uint8]
    ) -> tuple[NDArray[np.uint8], tuple[float, float, float, float]]:
        """The part of a picture of full size, and its extent for `imshow`, so that overlays keep full-size pixels."""
        x0, y0, x1, y1 = self.part
        return picture[y0:y1, x0:x1], (x0 - 0.5, x1 - 0.5, y1 - 0.5, y0 - 0.5)


def decoded(camera: str, jpeg: bytes) -> NDArray[np.uint8]:
    """The picture (H, W, 3) in RGB; raises ReportError when it is none."""
    colour = cv2.imdecode(np.frombuffer(jpeg, np.uint8), AS_SENSED) if jpeg else None
    if colour is None:
        raise ReportError(f"camera {camera}: {len(jpeg)} bytes are not a picture that can be decoded")
    return np.asarray(cv2.cvtColor(colour, cv2.COLOR_BGR2RGB), dtype=np.uint8)
