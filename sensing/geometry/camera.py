"""A calibrated camera as geometry: where points of the robot frame appear, and the rays through pixels.

OpenCV's pinhole model with lens distortion; integer pixel coordinates are pixel centres. Pictures are never
undistorted: the model is applied to the few points that are measured.
"""

import cv2
import numpy as np

from messaging.checked import FloatArray
from messaging.frames import CameraCalibration
from sensing.geometry.vectors import lengths


class Camera:
    """Projects points (n, 3) of the robot frame in mm to pixels (n, 2), and back to rays."""

    def __init__(self, calibration: CameraCalibration) -> None:
        self.name = calibration.camera
        self.size_px = calibration.width_px, calibration.height_px
        self._intrinsics = calibration.intrinsics
        self._distortion = calibration.distortion
        self.rotation = np.ascontiguousarray(calibration.camera_from_robot[:3, :3])
        self._translation = calibration.camera_from_robot[:3, 3].copy()
        self._rotation_vector = cv2.Rodrigues(self.rotation)[0]
        self.centre_mm: FloatArray = -self.rotation.T @ self._translation

    def project(self, points_mm: FloatArray) -> FloatArray:
        """Pixels (n, 2) of points (n, 3)."""
        pixels, _ = cv2.projectPoints(
            points_mm, self._rotation_vector, self._translation, self._intrinsics, self._distortion
        )
        return np.asarray(pixels.reshape(-1, 2), dtype=np.float64)

    def project_with_jacobian(self, points_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Pixels (n, 2) of points (n, 3), and their derivatives (n, 2, 3) by the points in px/mm."""
        pixels, jacobian = cv2.projectPoints(
            points_mm, self._rotation_vector, self._translation, self._intrinsics, self._distortion
        )
        # columns 3 to 5 are derivatives by the translation, that is by the point in the camera's own frame
        by_point = jacobian[:, 3:6].reshape(-1, 2, 3) @ self.rotation
        return np.asarray(pixels.reshape(-1, 2), dtype=np.float64), np.asarray(by_point)

    def px_per_mm(self, points_mm: FloatArray) -> FloatArray:
        """How large a millimetre across the sight appears at points (n, 3): (n,) in px/mm."""
        _, jacobian = self.project_with_jacobian(points_mm)
        return np.asarray(np.linalg.norm(jacobian, axis=(1, 2)) / np.sqrt(2.0))

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Unit directions (n, 3) in the robot frame of the rays from `centre_mm` through pixels (n, 2)."""
        ideal = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2),
            self._intrinsics,
            self._distortion,
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1e-9),
        ).reshape(-1, 2)
        directions = np.column_stack([ideal, np.ones(len(ideal))]) @ self.rotation
        return np.asarray(directions / lengths(directions))
