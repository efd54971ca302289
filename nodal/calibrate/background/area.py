"""Where in a picture the robot can be, and where the backdrop ends. Pure."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import COLLAR_MM, BaseView
from sensing.pictures.work_area import work_area_mask

Mask = NDArray[np.uint8]

MARGIN_MM = 8.0
"""Around the centreline: half a robot's width, its disks, and what straight edges of the work area cut off."""
BEHIND = 0.25
"""A robot that is bent round with one curvature comes behind its base by less than this share of its length."""
AZIMUTHS, ALTITUDES = 32, 17
STRAIGHT_PX = 6.0
"""A work area's corners are left out where its edge changes by less."""
EDGE_WIDTH = np.ones((9, 9), np.uint8)


@dataclass(frozen=True, kw_only=True)
class Reach:
    """What is known of where the robot can be: its length, how far the stage lifts its base, how wide its holder is; mm."""

    length_mm: float
    travel_mm: tuple[float, float]
    holder_radius_mm: float


def reach_mask(camera: Camera, reach: Reach) -> Mask:
    """Detection pixels (h, w) in which the robot can be seen (255)."""
    radius = reach.length_mm + MARGIN_MM
    azimuth = np.linspace(0, 2 * np.pi, AZIMUTHS, endpoint=False)
    height = np.linspace(-BEHIND * radius, radius, ALTITUDES)
    around = np.sqrt(radius**2 - height**2)
    points = np.array(
        [
            [r * np.cos(a), r * np.sin(a), z + lift]
            for lift in reach.travel_mm
            for r, z in zip(around, height, strict=True)
            for a in azimuth
        ]
    )
    hull = cv2.convexHull(camera.project(points).astype(np.float32))[:, 0]
    return work_area_mask(hull.astype(np.float64), Grid.of(camera.size_px))


def holder_mask(camera: Camera, reach: Reach, insertion_mm: float) -> Mask:
    """Detection pixels (h, w) that may show the holder (255), with the base at this height."""
    grid = Grid.of(camera.size_px)
    mask = np.zeros(grid.shape, dtype=np.uint8)
    strip = BaseView.of(camera, insertion_mm + COLLAR_MM, grid).below(reach.holder_radius_mm, sum(grid.shape))
    cv2.fillConvexPoly(mask, np.rint(strip).astype(np.int32), 255)
    return np.asarray(cv2.dilate(mask, EDGE_WIDTH), dtype=np.uint8)


def work_area(camera: Camera, reach: Reach, beyond: Mask) -> FloatArray | None:
    """Corners (n, 2) in px of where the robot can be, without what lies `beyond` (h, w) the backdrop, in detection pixels.

    None when that is the whole picture. Where the cut would take the base away nothing is cut.
    """
    grid = Grid.of(camera.size_px)
    reached = reach_mask(camera, reach)
    cut = cv2.bitwise_and(reached, cv2.bitwise_not(np.asarray(cv2.dilate(beyond, EDGE_WIDTH))))
    base = np.array([[0.0, 0.0, height] for height in reach.travel_mm])
    seen = grid.coarse(camera.project(base))
    for mask in (cut, reached):
        corners = _outline(np.asarray(mask, dtype=np.uint8), seen[0])
        if corners is not None and all(_holds(corners, place) for place in seen if _shown(place, grid)):
            if mask.all():
                return None
            return _to_the_edge(grid.fine(corners), camera.size_px, grid.step)
    return None


def _outline(mask: Mask, base: FloatArray) -> FloatArray | None:
    """The outline (n, 2) of the part of a mask that holds the base."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for contour in contours:
        outline = cv2.approxPolyDP(contour, STRAIGHT_PX, closed=True)[:, 0].astype(np.float64)
        if len(outline) >= 3 and _holds(outline, base):
            return outline
    return None


def _to_the_edge(corners: FloatArray, size_px: tuple[int, int], step: int) -> FloatArray:
    """Corners (n, 2) in px, those at the picture's edge right on it."""
    last, near = np.array(size_px) - 1.0, (STRAIGHT_PX + 1) * step
    snapped = np.where(corners < near, 0.0, np.where(corners > last - near, last, np.rint(corners)))
    return np.asarray(snapped, dtype=np.float64)


def _holds(corners: FloatArray, place: FloatArray) -> bool:
    x, y = place
    return cv2.pointPolygonTest(corners.astype(np.float32), (float(x), float(y)), measureDist=False) >= 0


def _shown(place: FloatArray, grid: Grid) -> bool:
    height, width = grid.shape
    return bool(0 <= place[0] < width and 0 <= place[1] < height)
