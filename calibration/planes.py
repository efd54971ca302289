"""Maps between a plane and its picture: homographies, (3, 3)."""

import cv2
import numpy as np

from calibration.corners import Array

THINNEST = 1e-3
"""Width over length of points that lie in a line."""


def homography(flat: Array, px: Array) -> Array | None:
    """The map that takes points (n, 2) of a plane to their pixels (n, 2), by least squares; None if they lie in a line."""
    spread = np.linalg.svd(flat - flat.mean(axis=0), compute_uv=False)
    if len(flat) < 4 or spread[1] < THINNEST * spread[0]:
        return None
    found, _ = cv2.findHomography(flat, px)
    return None if found is None else np.asarray(found, np.float64)


def mapped(plane_map: Array, flat: Array) -> Array:
    """Where points (..., 2) go."""
    ahead = flat @ plane_map[:, :2].T + plane_map[:, 2]
    return np.asarray(ahead[..., :2] / ahead[..., 2:])


def sides_at(plane_map: Array, flat: Array) -> Array:
    """The unit steps along both axes of the plane as they go at points (n, 2): (n, 2, 2), one in each row."""
    return np.stack(
        [mapped(plane_map, flat + step) - mapped(plane_map, flat - step) for step in 0.5 * np.eye(2)], axis=1
    )
