"""Cameras that were calibrated together: what each is, where it stands among the others, and how well that is known.

The rig frame is the first camera's own: `x_camera = camera_from_rig @ x_rig` on homogeneous points in mm, and the first
camera's `camera_from_rig` is the identity. Where the robot stands in it is found apart, by `nodal calibrate base`.
"""

from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from messaging.board import BoardSettings
from messaging.frames import CameraCalibration

Array = NDArray[np.float64]
Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]


class CalibratedCamera(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One camera: OpenCV's pinhole model; integer pixel coordinates are pixel centres.

    `intrinsics` is K in px, `distortion` [k1, k2, p1, p2, k3]. `sigma` holds the standard deviation of each parameter that
    was estimated, by its name: fx_px, fy_px, cx_px, cy_px, k1, k2, p1, p2, k3, and the pose's rotation_x_rad, rotation_y_rad,
    rotation_z_rad, x_mm, y_mm, z_mm: rotations of `camera_from_rig` in the camera's axes, and its translation as it stands.
    Reprojection errors are RMS over both coordinates of all corners, in px; the held-out one is of views that the camera was
    not calibrated with, predicted by the other cameras (calibration/holding_out.py).
    """

    name: str
    width_px: int
    height_px: int
    intrinsics: tuple[Row3, Row3, Row3]
    distortion: tuple[float, float, float, float, float]
    camera_from_rig: tuple[Row4, Row4, Row4, Row4]
    sigma: dict[str, float] = {}
    views: int = 0
    rms_px: float | None = None
    held_out_rms_px: float | None = None
    empty_ninths: int | None = None
    """How many ninths of its picture hardly a corner was seen in."""

    @classmethod
    def of(cls, camera: CameraCalibration, camera_from_rig: Array) -> "CalibratedCamera":
        """A camera that somebody else calibrated; `camera_from_rig` (4, 4), mm."""
        known = {
            "name": camera.camera,
            "width_px": camera.width_px,
            "height_px": camera.height_px,
            "intrinsics": camera.intrinsics.tolist(),
            "distortion": camera.distortion.tolist(),
            "camera_from_rig": camera_from_rig.tolist(),
        }
        return msgspec.convert(known, cls)

    def in_robot_frame(self, rig_from_robot: Array) -> CameraCalibration:
        """The camera as sensing knows it; `rig_from_robot` (4, 4), mm. Raises InvalidMessageError for what no camera can be."""
        return CameraCalibration(
            camera=self.name,
            width_px=self.width_px,
            height_px=self.height_px,
            intrinsics=np.array(self.intrinsics),
            distortion=np.array(self.distortion),
            camera_from_robot=np.array(self.camera_from_rig) @ rig_from_robot,
        )


class BoardCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The board, measured in 3-D from all cameras that see it at once, in views that were held out, against its shape as it was solved for.

    It says what space is like to these cameras, not how large: that was solved for with the same squares.
    """

    squares: int
    """How many sides of squares were measured."""
    mean_error_mm: float
    rms_error_mm: float
    """Of the length of a side, measured minus solved for."""
    surface_error_mm: float
    """RMS distance of the measured corners from the board's surface."""


class CameraSet(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """All cameras of a bench, and how they were calibrated."""

    cameras: Annotated[tuple[CalibratedCamera, ...], msgspec.Meta(min_length=1)]
    board: BoardSettings | None = None
    made_at: str = ""
    """ISO 8601, UTC."""
    views_used: int = 0
    views_rejected: dict[str, str] = {}
    """Why, by the name of the view."""
    missing: tuple[str, ...] = ()
    """What the views that were used did not show, in words (calibration/coverage.py)."""
    board_check: BoardCheck | None = None
    board_shape: dict[str, float] = {}
    """How the board differs from a flat and true one (calibration/rig.py: SHAPE)."""

    @classmethod
    def of_rig(cls, rig: Sequence[CameraCalibration]) -> "CameraSet":
        """The cameras of a calibration file, whoever made it, among one another."""
        rig_from_robot = rig[0].camera_from_robot
        return cls(
            cameras=tuple(
                CalibratedCamera.of(camera, camera.camera_from_robot @ np.linalg.inv(rig_from_robot))
                for camera in rig
            )
        )

    def in_robot_frame(self, rig_from_robot: Array) -> tuple[CameraCalibration, ...]:
        """The rig as sensing knows it."""
        return tuple(camera.in_robot_frame(rig_from_robot) for camera in self.cameras)
