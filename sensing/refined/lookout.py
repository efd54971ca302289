"""A quick look around a fitted tube, which says whether the robot is there and whether there is more of it.

A warm estimate measures edges near where the robot was last. It cannot see that the tube has come to lie on something
else, that the robot folds over itself, or that something of its size touches it. This look takes brightness alone, in
pixels of which the tube is a few wide, so that specks, the rims of spacer disks and thin shadows vanish.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import CONTRAST_SHARE, BaseView, Limits, Mask
from sensing.pictures.work_area import work_area_mask
from sensing.refined.measuring import View
from sensing.refined.tube import Curve
from sensing.refined.tube_mask import tube_mask, widened

ACROSS_PX = 5.0
"""The tube is about so many coarse pixels wide."""
RIM_PX = 1.0
"""What spacer disks, blur and the motion since the fit add to the tube's half width."""
LEAST_LEVELS = 4.0
NOISE_FACTOR = 3.0
"""In pixels as coarse as these little noise is left: the backdrop differs by as much as it is off by."""
LEAST_EXPLAINED = 0.9
MOST_ELSEWHERE = 0.4
AROUND = 3.0
"""So many of the tube's widths around it are looked at."""
THICK = np.ones((3, 3), np.uint8)
"""What is not as wide as this, in coarse pixels, is not the robot."""


@dataclass(frozen=True)
class Look:
    """What one camera sees in and around the tube.

    `explained` is the share of the tube's inside that stands out from the backdrop (NaN where the tube is not in the
    picture), `elsewhere` the area of what stands out beside it and hangs together with it, in squares as wide as the tube.
    """

    explained: float
    elsewhere: float

    @property
    def surprising(self) -> bool:
        """Whether the robot should be found anew."""
        return not self.explained >= LEAST_EXPLAINED or self.elsewhere > MOST_ELSEWHERE


NOTHING = Look(float("nan"), 0.0)
"""The tube is not in the picture, or a dot in it."""


def look_around(view: View, fitted: Curve, insertion_mm: float, limits: Limits) -> Look:
    """Look at a picture in and around a fitted tube, as far as the view shows it."""
    detection, base = Grid.of(view.camera.size_px), BaseView.of(view.camera, insertion_mm)
    width_px = 2 * float(np.median(fitted.radius_mm)) * base.px_per_mm * detection.step
    step = max(int(width_px / ACROSS_PX), 1)
    view = _around(view, fitted, AROUND * width_px, step)
    grid = Grid((view.picture.shape[1], view.picture.shape[0]), step)
    if not view.picture.size:
        return NOTHING
    tube, half_width = tube_mask(view.camera, fitted, grid, view.corner)
    inside = cv2.erode(tube, THICK) > 0
    if not inside.any():
        return NOTHING
    around = widened(tube, RIM_PX)
    free = ~around
    holder = detection.fine(base.below(limits.holder_radius_mm, sum(detection.shape))) - view.corner
    cv2.fillConvexPoly(free, np.rint(grid.coarse(holder) * 16).astype(np.int32), 0, shift=4)
    if limits.work_area is not None:
        free &= work_area_mask(limits.work_area - view.corner, grid)
    difference = cv2.absdiff(grid.reduced(view.picture), grid.reduced(view.backdrop))
    contrast = float(np.median(difference[inside]))
    noise = float(np.median(difference[free > 0])) if free.any() else 0.0
    level = max(LEAST_LEVELS, CONTRAST_SHARE * contrast, NOISE_FACTOR * noise)
    standing_out = (difference > level).view(np.uint8) * np.uint8(255)
    explained = float(np.mean(standing_out[inside] > 0))
    thick = np.asarray(cv2.morphologyEx(standing_out & free, cv2.MORPH_OPEN, THICK), dtype=np.uint8)
    return Look(explained, _joined(thick, around) / (2 * half_width) ** 2)


def _around(view: View, fitted: Curve, margin_px: float, step: int) -> View:
    """The part of a view that shows a tube and this much around it, its size a multiple of `step`."""
    pixels = view.camera.project(fitted.points_mm) - view.corner
    size = view.picture.shape[::-1]
    low = np.clip(np.floor(pixels.min(axis=0) - margin_px), 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0) + margin_px), 0, size).astype(int)
    high -= (high - low) % step
    part = slice(low[1], high[1]), slice(low[0], high[0])
    return View(view.camera, view.picture[part], view.backdrop[part], view.corner + low)


def _joined(parts: Mask, to: Mask) -> int:
    """How many pixels of a mask hang together with another's."""
    if not parts.any():
        return 0
    labels = np.asarray(cv2.connectedComponents(parts | to, connectivity=8)[1])
    return int(np.count_nonzero(np.isin(labels[parts > 0], np.unique(labels[to > 0]))))
