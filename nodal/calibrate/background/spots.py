"""What lies on a backdrop and where it ends, told from a smooth surface through it. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from nodal.calibrate.background.area import Mask
from nodal.calibrate.background.statistics import Box, Statistics
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image
from sensing.pictures.surface import Surface

STANDS_OUT, OVER_NOISE = 8.0, 5.0
"""Levels by which a spot differs from the smooth backdrop at least, and times the noise of the mean picture."""
SMALLEST_SPOT_MM2 = 3.0
FOREIGN, BEYOND_SHARE, BEYOND_IN_REACH = 35.0, 0.005, 0.02
"""What has a colour so many levels from the backdrop's, touches the picture's edge and is so large a share of the picture lies beyond the backdrop; it counts
where so much of it lies within reach."""
SHARP = 0.3
"""Across its edge a thing loses so much of its distance from the backdrop at least; a soft shadow does not."""
CLOSING, NEAR = np.ones((9, 9), np.uint8), np.ones((5, 5), np.uint8)
MOST_SPOTS = 40


class Spot(msgspec.Struct, frozen=True, kw_only=True):
    """Something on the backdrop within the robot's reach, in px; `levels` is by how much it is brighter (or darker, below 0)."""

    box_px: Box
    levels: float
    area_mm2: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Backing:
    """A mean picture and a smooth surface through it, both (h, w, 3) in detection pixels, and how far they differ (h, w).

    Where `elsewhere` (h, w) is 0 stands the holder.
    """

    small: Image
    elsewhere: Mask
    surface: Image
    distance: NDArray[np.float32]
    differing: Mask

    @classmethod
    def of(cls, statistics: Statistics, elsewhere: Mask) -> "Backing":
        """Nothing differs where the holder stands."""
        height, width = statistics.mean.shape[:2]
        grid = Grid.of((width, height))
        small = grid.reduced(statistics.mean)
        surface = Surface.fitted(small, grid).painted((width, height), grid.shape)
        apart = np.linalg.norm(small.astype(np.float32) - surface.astype(np.float32), axis=2)
        distance = np.asarray(cv2.GaussianBlur(apart, (0, 0), 1.0), dtype=np.float32)
        grain = float(np.linalg.norm(statistics.noise)) / np.sqrt(statistics.count)
        least = max(STANDS_OUT, OVER_NOISE * grain, 3.0 * float(np.median(distance)))
        return cls(
            small=small,
            elsewhere=elsewhere,
            surface=surface,
            distance=distance,
            differing=elsewhere * (distance > least),
        )

    def beyond(self, looked: Mask) -> Mask:
        """What lies beyond the backdrop (255), as far as it comes into what is looked at (h, w)."""
        middle = np.median(self.small[looked > 0], axis=0)
        distance = np.linalg.norm(self.small - middle, axis=2).astype(np.float32)
        closed = cv2.morphologyEx(self.elsewhere * (distance > FOREIGN), cv2.MORPH_CLOSE, CLOSING)
        _, labels, boxes, _ = cv2.connectedComponentsWithStats(closed, connectivity=8)
        height, width = closed.shape
        beyond = np.zeros((height, width), dtype=np.uint8)
        for label, (x, y, across, down, area) in enumerate(boxes[1:], start=1):
            if area < BEYOND_SHARE * height * width:
                continue
            part = labels == label
            at_edge = x == 0 or y == 0 or x + across == width or y + down == height
            in_reach = float((looked[part] > 0).mean()) > BEYOND_IN_REACH
            if at_edge and in_reach and sharpness(distance, part.astype(np.uint8)) > SHARP:
                beyond[part] = 255
        return beyond

    def spots(self, looked: Mask, beyond: Mask, mm2_per_px: float, step: int) -> Iterator[Spot]:
        """Things on the backdrop with an edge, the largest first; `step` is a detection pixel's size in px."""
        brighter = self.small.astype(np.float32).mean(axis=2) - self.surface.astype(np.float32).mean(axis=2)
        seen = self.differing & looked & ~beyond
        _, labels, boxes, _ = cv2.connectedComponentsWithStats(seen)
        for label in sorted(range(1, len(boxes)), key=lambda label: -boxes[label][4])[:MOST_SPOTS]:
            x, y, width, height, area = (int(value) for value in boxes[label])
            part = labels == label
            if (
                area * mm2_per_px < SMALLEST_SPOT_MM2
                or sharpness(self.distance, part.astype(np.uint8)) < SHARP
            ):
                continue
            levels = brighter[part]
            yield Spot(
                box_px=(x * step, y * step, width * step, height * step),
                levels=float(levels[np.abs(levels).argmax()]),
                area_mm2=area * mm2_per_px,
            )


def sharpness(distance: NDArray[np.float32], mask: Mask) -> float:
    """What share of its distance from the backdrop a thing in a mask (h, w) loses across its edge: 1 for an edge, 0 for a slope."""
    within = (mask > 0) & (np.asarray(cv2.erode(mask, NEAR)) == 0)
    around = (np.asarray(cv2.dilate(mask, NEAR)) > 0) & (mask == 0)
    if not (within.any() and around.any()):
        return 0.0
    inner, outer = float(np.median(distance[within])), float(np.median(distance[around]))
    return (inner - outer) / max(inner, 1e-6)
