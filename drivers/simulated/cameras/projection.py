"""One camera's geometry: from the robot frame to pixels, and from pixels to rays.

OpenCV's pinhole model with distortion [k1, k2, p1, p2, k3]; integer pixel coordinates are pixel centres.
"""

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Index
from drivers.simulated.cameras.canvas import Window
from messaging.frames import CameraCalibration

_INVERSION = (
    cv2.TERM_CRITERIA_MAX_ITER,
    15,
    0.0,
)  # each round gains about a digit; looking for it would cost more


class Lens:
    """A camera: from the robot frame to pixels."""

    def __init__(self, calibration: CameraCalibration) -> None:
        self.width_px, self.height_px = calibration.width_px, calibration.height_px
        self.rotation = calibration.camera_from_robot[:3, :3]
        """(3, 3) camera_from_robot, also for directions."""
        self._translation_mm = calibration.camera_from_robot[:3, 3]
        self._intrinsics = calibration.intrinsics
        self._distortion = calibration.distortion
        self.focal_px = float(np.sqrt(self._intrinsics[0, 0] * self._intrinsics[1, 1]))

    @property
    def centre_mm(self) -> Array:
        """(3,) where it stands in the robot frame."""
        centre: Array = -self.rotation.T @ self._translation_mm
        return centre

    def to_camera(self, robot_mm: Array) -> Array:
        """Points (..., 3) of the robot frame in the camera frame, z along the view."""
        return robot_mm @ self.rotation.T + self._translation_mm

    def to_pixels(self, camera_mm: Array) -> Array:
        """Pixel coordinates (..., 2) of points (..., 3) in the camera frame."""
        x, y = camera_mm[..., 0] / camera_mm[..., 2], camera_mm[..., 1] / camera_mm[..., 2]
        k1, k2, p1, p2, k3 = self._distortion
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        K = self._intrinsics
        u = K[0, 0] * bent_x + K[0, 1] * bent_y + K[0, 2]
        return np.stack([u, K[1, 1] * bent_y + K[1, 2]], axis=-1)

    def from_straight_ray(self, pixels: Array, away_mm: Array) -> Array:
        """Points (n, 3) in the robot frame, so far (n,) along the view, that pixels (n, 2) see through a lens without distortion."""
        rays = np.linalg.solve(self._intrinsics, np.column_stack([pixels, np.ones(len(pixels))]).T).T
        points: Array = (away_mm[:, None] * rays - self._translation_mm) @ self.rotation
        return points


class Projection(Lens):
    """A camera, with the ray of each of its pixels at hand."""

    def __init__(self, calibration: CameraCalibration) -> None:
        super().__init__(calibration)
        self._ray_x, self._ray_y = self._rays_of_pixels()

    def rays(self, place: Index) -> tuple[Flat, Flat]:
        """X and y of pixels at places of any shape, counted row by row: a pixel sees along (x, y, 1) in the camera frame."""
        return self._ray_x.take(place, mode="clip"), self._ray_y.take(place, mode="clip")

    def rays_in(self, window: Window) -> tuple[Flat, Flat]:
        """X and y (rows, columns) of the rays of a window's pixels."""
        shape = self.height_px, self.width_px
        return self._ray_x.reshape(shape)[window.slices], self._ray_y.reshape(shape)[window.slices]

    def _rays_of_pixels(self) -> tuple[Flat, Flat]:
        columns, rows = np.meshgrid(np.arange(float(self.width_px)), np.arange(float(self.height_px)))
        pixels = np.stack([columns, rows], axis=-1).reshape(-1, 1, 2)
        rays = cv2.undistortPoints(pixels, self._intrinsics, self._distortion, criteria=_INVERSION)
        rays = np.ascontiguousarray(rays.reshape(-1, 2).T, dtype=np.float32)
        return rays[0], rays[1]
