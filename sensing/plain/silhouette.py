"""Which pixels are the robot, at full size (METHOD steps 2 and 3).

Equation 1, area opening, morphological closing; then the part that is joined to the base. The holder is in view too, and
often in one piece with the robot: the base's known place and direction say where the robot begins.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image
from sensing.pictures.segmentation import SMALLEST_ROBOT_MM2, BaseView, Mask, Places, threshold_at_base
from sensing.pictures.work_area import work_area_mask

NOISE_STRIDE = 4
CLOSING_MM = 1.2
"""Closing fills gaps that are narrower."""
LARGEST_SHARE = 0.5
"""Where more of a picture stands out, backdrop or threshold are wrong."""


def colour_distance(picture: Image, backdrop: Image) -> NDArray[np.float32]:
    """The square of equation 1's left side, (h, w), from two BGR pictures (h, w, 3)."""
    square = np.zeros(picture.shape[:2], np.float32)
    for difference in cv2.split(cv2.absdiff(picture, backdrop)):
        cv2.accumulateSquare(difference, square)
    return square


def area_opened(mask: Mask, least_px: float) -> Mask:
    """The mask (0 or 255) without its parts of fewer pixels than this."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    kept = np.where(statistics[:, cv2.CC_STAT_AREA] >= least_px, np.uint8(255), np.uint8(0))
    kept[0] = 0
    return np.asarray(kept[labels])


def closed(mask: Mask, reach_px: int) -> Mask:
    """The mask with gaps of up to twice this width filled and its border smoothed."""
    size_px = 2 * reach_px + 1
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size_px, size_px))
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, disk), dtype=np.uint8)


def without_holder(mask: Mask, base: BaseView, radius_mm: float) -> Mask:
    """The mask without what lies below the base and within this distance of its axis."""
    strip = base.below(radius_mm, sum(mask.shape))
    return np.asarray(cv2.fillConvexPoly(mask.copy(), strip.round().astype(np.int32), 0))


def joined_to_base(mask: Mask, at_base: Places) -> Mask:
    """The one part of the mask that covers most of the axis above the base; all 0 where none does."""
    _, labels = cv2.connectedComponents(mask, connectivity=8)
    touched = labels[at_base]
    touched = touched[touched > 0]
    if not touched.size:
        return np.zeros_like(mask)
    return np.where(labels == np.bincount(touched).argmax(), np.uint8(255), np.uint8(0))


def silhouette(
    camera: Camera,
    picture: Image,
    backdrop: Image,
    base: BaseView,
    *,
    holder_radius_mm: float,
    work_area: FloatArray | None,
    threshold: float | None,
) -> Mask:
    """The robot's pixels (h, w), 255, in a BGR picture (h, w, 3); raises RefusedError when there is no robot.

    `work_area` is a polygon (n, 2) in px, or None for the whole picture; `threshold` is equation 1's T in levels, or None
    for one that follows from noise and contrast.
    """
    at_base = base.axis_in(camera.name, picture.shape)
    square = colour_distance(picture, backdrop)
    noise = float(np.sqrt(np.median(square[::NOISE_STRIDE, ::NOISE_STRIDE])))
    contrast = float(np.sqrt(np.median(square[at_base])))
    levels = threshold_at_base(camera.name, contrast, noise, threshold)
    mask = np.where(square > levels**2, np.uint8(255), np.uint8(0))
    if work_area is not None:
        mask = np.asarray(cv2.bitwise_and(mask, work_area_mask(work_area, Grid(camera.size_px, 1))), np.uint8)
    if np.count_nonzero(mask) > LARGEST_SHARE * mask.size:
        raise RefusedError(
            f"camera {camera.name}: {100 * np.count_nonzero(mask) / mask.size:.0f} % of the picture stand out from the "
            f"backdrop (threshold {levels:.0f} levels), {100 * LARGEST_SHARE:.0f} % at most can be robot and holder"
        )
    opened = area_opened(mask, SMALLEST_ROBOT_MM2 * base.px_per_mm**2)
    whole = closed(opened, max(round(CLOSING_MM * base.px_per_mm / 2), 1))
    robot = joined_to_base(without_holder(whole, base, holder_radius_mm), at_base)
    if not robot.any():
        raise RefusedError(f"camera {camera.name}: no robot is joined to its base")
    return robot


def reaches_rim(mask: Mask, work_area: FloatArray | None) -> bool:
    """Whether a mask (h, w) touches the rim of its picture, or of its work area (n, 2) in px."""
    height, width = mask.shape
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]])
    outlines = [corners] if work_area is None else [corners, work_area.round().astype(np.int32)]
    rim = cv2.polylines(np.zeros_like(mask), [line.astype(np.int32) for line in outlines], True, 255, 3)
    return bool(cv2.bitwise_and(mask, rim).any())
