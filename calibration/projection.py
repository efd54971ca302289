"""OpenCV's pinhole model with its derivatives, and small turns of poses."""

import cv2
import numpy as np

from calibration.corners import Array

INTRINSICS = ("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3")
"""What a camera's nine numbers are, in this order; the last five are OpenCV's distortion."""
POSE = ("rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_mm", "y_mm", "z_mm")


def matrix(intrinsics: Array) -> Array:
    """K (3, 3)."""
    fx, fy, cx, cy = intrinsics[:4]
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def project(intrinsics: Array, points_mm: Array) -> tuple[Array, Array, Array]:
    """Pixels (n, 2) of points (n, 3) in the camera's frame, and their derivatives by the points and by the intrinsics.

    Those are (n, 2, 3) and (n, 2, 9). The model is that of OpenCV's cv2.projectPoints with [k1, k2, p1, p2, k3].
    """
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = intrinsics
    depth = points_mm[:, 2]
    x, y = points_mm[:, 0] / depth, points_mm[:, 1] / depth
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    by_r2 = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3)
    u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    u_x = radial + 2.0 * x * x * by_r2 + 2.0 * p1 * y + 6.0 * p2 * x
    cross = 2.0 * x * y * by_r2 + 2.0 * p1 * x + 2.0 * p2 * y
    v_y = radial + 2.0 * y * y * by_r2 + 6.0 * p1 * y + 2.0 * p2 * x
    by_point = np.empty((len(depth), 2, 3))
    by_point[:, 0, 0], by_point[:, 0, 1] = fx * u_x / depth, fx * cross / depth
    by_point[:, 1, 0], by_point[:, 1, 1] = fy * cross / depth, fy * v_y / depth
    by_point[:, :, 2] = -(by_point[:, :, 0] * x[:, None] + by_point[:, :, 1] * y[:, None])
    zero, one = np.zeros_like(x), np.ones_like(x)
    powers = np.stack([r2, r2**2, r2**3], axis=1)
    by_intrinsics = np.empty((len(depth), 2, 9))
    by_intrinsics[:, 0, :4] = np.stack([u, zero, one, zero], axis=1)
    by_intrinsics[:, 1, :4] = np.stack([zero, v, zero, one], axis=1)
    by_intrinsics[:, 0, [4, 5, 8]] = fx * x[:, None] * powers
    by_intrinsics[:, 1, [4, 5, 8]] = fy * y[:, None] * powers
    by_intrinsics[:, 0, 6], by_intrinsics[:, 0, 7] = fx * 2.0 * x * y, fx * (r2 + 2.0 * x * x)
    by_intrinsics[:, 1, 6], by_intrinsics[:, 1, 7] = fy * (r2 + 2.0 * y * y), fy * 2.0 * x * y
    return np.column_stack([fx * u + cx, fy * v + cy]), by_point, by_intrinsics


def undistorted(intrinsics: Array, px: Array) -> Array:
    """Pixels (n, 2) as points (n, 2) of the plane at depth one."""
    return np.asarray(
        cv2.undistortPoints(
            px.reshape(-1, 1, 2),
            matrix(intrinsics),
            intrinsics[4:],
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 1e-10),
        ).reshape(-1, 2),
        np.float64,
    )


def moved(pose: Array, step: Array) -> Array:
    """A pose (4, 4) turned about its own origin by `step[:3]` rad and shifted by `step[3:]` mm, in the frame it leads to.

    The six numbers are those that POSE names: a rotation in the axes of the frame that the pose leads to, and the change of
    its translation.
    """
    result = pose.copy()
    result[:3, :3] = cv2.Rodrigues(step[:3])[0] @ pose[:3, :3]
    result[:3, 3] += step[3:]
    return result


def by_pose(pose: Array, points_mm: Array) -> Array:
    """Derivatives (n, 3, 6) of `pose` times points (n, 3) by the step of `moved`."""
    x, y, z = (points_mm @ pose[:3, :3].T).T
    derivatives = np.zeros((len(points_mm), 3, 6))
    derivatives[:, 0, 1], derivatives[:, 0, 2] = z, -y
    derivatives[:, 1, 0], derivatives[:, 1, 2] = -z, x
    derivatives[:, 2, 0], derivatives[:, 2, 1] = y, -x
    derivatives[:, [0, 1, 2], [3, 4, 5]] = 1.0
    return derivatives


def transformed(pose: Array, points_mm: Array) -> Array:
    """`pose` times points (n, 3)."""
    return np.asarray(points_mm @ pose[:3, :3].T + pose[:3, 3])
