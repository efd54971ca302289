"""The fitted tube drawn as a camera sees it, to hold against what stands out from the backdrop."""

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import Mask
from sensing.refined.tube import Curve, sides

FAR_PX = 1e5
"""A curve that fits nothing may lie anywhere, and be of any size; drawing takes no coordinates beyond this."""
STRIDE = 4
ORIGIN: FloatArray = np.zeros(2)


def tube_mask(camera: Camera, fitted: Curve, grid: Grid, corner: FloatArray = ORIGIN) -> tuple[Mask, float]:
    """The tube's pixels (255) in a grid whose picture begins at `corner` px of the camera's, and its half width there."""
    edges = sides(camera.centre_mm[None], fitted)
    pixels = camera.project(np.concatenate([edges.one[0, ::STRIDE], edges.other[0, ::STRIDE]]))
    one, other = grid.coarse(pixels - corner).clip(-FAR_PX, FAR_PX).reshape(2, -1, 2)
    strips = np.stack([one[:-1], one[1:], other[1:], other[:-1]], axis=1)
    mask = np.zeros(grid.shape, dtype=np.uint8)
    for strip in np.rint(strips * 16).astype(np.int32):
        cv2.fillConvexPoly(mask, strip, 255, shift=4)
    return mask, float(np.median(np.linalg.norm(one - other, axis=1))) / 2


def widened(mask: Mask, by_px: float) -> Mask:
    """The mask with a rim of about this many pixels around it."""
    rim = max(min(int(np.ceil(by_px)), min(mask.shape) // 4), 0)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * rim + 1, 2 * rim + 1))
    return np.asarray(cv2.dilate(mask, disk), dtype=np.uint8)
