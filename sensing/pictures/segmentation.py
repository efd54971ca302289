"""Which pixels are the robot (METHOD steps 2 and 3), at detection size.

The base is where the calibration says it is, so the robot is what stands out from the backdrop there and what hangs
together with it; the threshold lies between the noise and the contrast seen at the base. Below the base, within the
holder's radius, nothing is robot: that is how the holder, which may join the silhouette, is told from it. Nor is what
the robot is too short to reach, or what lies outside of the work area.

A soft shadow on the backdrop is the backdrop's own colour, darker: it is told from the robot wherever the robot's colour
is another.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop, Window, noise_level
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image
from sensing.pictures.work_area import work_area_mask

Mask = NDArray[np.uint8]
Places = tuple[NDArray[np.int_], ...]
"""Rows and columns (n,)."""

AXIS_MM: FloatArray = np.arange(3.0, 9.0, 0.5)
"""Heights above the base at which the robot's contrast is read off its nearly straight beginning."""
CONTRAST_SHARE = 0.4
NOISE_FACTOR = 5.0
LEAST_DISTANCE = 5.0
"""Colour distance that tells nothing from the backdrop, even where the backdrop shows no noise at all."""
DEEPEST_SHADOW = 0.45
"""A soft shadow leaves at least this share of the backdrop's level."""
COLLAR_MM = 4.0
"""From above the holder's top face is seen as far above the base as this."""
SMALLEST_ROBOT_MM2 = 10.0
CLOSING = np.ones((5, 5), np.uint8)
BEYOND_REACH = 1.1
"""The picture is searched as far from the base as this many times the robot's length."""


@dataclass(frozen=True)
class Limits:
    """What is known of where the robot can be, and of how it differs from the backdrop.

    `work_area` (n, 2) are a polygon's corners in px; `threshold` is equation 1's T, in levels.
    """

    holder_radius_mm: float
    length_mm: float | None = None
    work_area: FloatArray | None = None
    threshold: float | None = None


@dataclass(frozen=True)
class BaseView:
    """Where a camera sees the base: in pixels of a grid, the base's place, the axis above it, +Z's direction and the scale."""

    pixel: FloatArray
    axis_pixels: FloatArray
    up: FloatArray
    px_per_mm: float

    @classmethod
    def of(cls, camera: Camera, insertion_mm: float, grid: Grid | None = None) -> "BaseView":
        """The base at this insertion, in detection pixels if no other grid is given."""
        heights = np.concatenate([[0.0], AXIS_MM]) + insertion_mm
        places = np.column_stack([0 * heights, 0 * heights, heights])
        pixels = (grid or Grid.of(camera.size_px)).coarse(camera.project(places))
        along = pixels[-1] - pixels[0]
        length = float(np.linalg.norm(along))
        return cls(pixels[0], pixels[1:], along / length, length / AXIS_MM[-1])

    def below(self, radius_mm: float, depth_px: float) -> FloatArray:
        """Corners (4, 2) of the strip that reaches from the base downwards, as wide to either side of the axis: the holder's."""
        across = radius_mm * self.px_per_mm * np.array([-self.up[1], self.up[0]])
        down = -depth_px * self.up
        return np.asarray(self.pixel + np.array([across, across + down, down - across, -across]))

    def axis_in(self, name: str, shape: tuple[int, ...]) -> Places:
        """The axis' pixels in a camera's picture (h, w); raises RefusedError when none lies in it."""
        columns, rows = self.axis_pixels.round().astype(int).T
        inside = (columns >= 0) & (columns < shape[1]) & (rows >= 0) & (rows < shape[0])
        if not inside.any():
            raise RefusedError(f"camera {name}: the robot's base is outside the picture")
        return rows[inside], columns[inside]


def threshold_at_base(name: str, contrast: float, noise: float, given: float | None) -> float:
    """Equation 1's T in levels: the given one, or one between noise and the contrast where the robot leaves its base.

    Raises RefusedError when the robot does not stand out from the backdrop there.
    """
    threshold = given or max(LEAST_DISTANCE, NOISE_FACTOR * noise, CONTRAST_SHARE * contrast)
    if contrast <= threshold:
        raise RefusedError(
            f"camera {name}: nothing stands out from the backdrop where the robot leaves its base "
            f"(colour distance {contrast:.0f}, backdrop {noise:.0f}, threshold {threshold:.0f})"
        )
    return threshold


def robot_mask(name: str, small: Image, backdrop: Backdrop, base: BaseView, limits: Limits) -> Mask:
    """The robot's pixels (255) in a picture (h, w, 3) in detection pixels; raises RefusedError when there is no robot."""
    rows, columns = base.axis_in(name, small.shape)
    window = _searched(small.shape, base, limits)
    top, left = window[0].start, window[1].start
    at_base = rows - top, columns - left
    distance = backdrop.distance(small[window], window)
    if limits.work_area is not None:
        distance[work_area_mask(limits.work_area, backdrop.grid)[window] == 0] = 0.0
    noise = noise_level(distance)
    threshold = threshold_at_base(name, float(np.median(distance[at_base])), noise, limits.threshold)
    mask = (distance > threshold).view(np.uint8) * np.uint8(255)
    holder = base.below(limits.holder_radius_mm, sum(mask.shape)) - (left, top)
    cv2.fillConvexPoly(mask, np.rint(holder * 16).astype(np.int32), 0, shift=4)
    if limits.threshold is None:
        _drop_shadows(mask, small[window], backdrop.small[window], at_base, noise)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, CLOSING), dtype=np.uint8)
    whole = np.zeros(small.shape[:2], dtype=np.uint8)
    whole[window] = _component_at_base(name, mask, at_base, base.px_per_mm**2)
    return whole


def _searched(shape: tuple[int, ...], base: BaseView, limits: Limits) -> Window:
    """The part of a picture that the robot can reach from its base."""
    if limits.length_mm is None:
        return slice(0, shape[0]), slice(0, shape[1])
    reach = BEYOND_REACH * limits.length_mm * base.px_per_mm
    low, high = np.floor(base.pixel - reach).astype(int), np.ceil(base.pixel + reach).astype(int)
    return (
        slice(max(low[1], 0), min(high[1], shape[0])),
        slice(max(low[0], 0), min(high[0], shape[1])),
    )


def _drop_shadows(mask: Mask, picture: Image, empty: Image, at_base: Places, noise: float) -> None:
    """Take out of a mask what has the backdrop's colour and is merely darker, where the robot's colour is another."""
    _, own = _shade(picture[at_base], empty[at_base])
    robot = float(np.median(own))
    if robot < max(LEAST_DISTANCE, NOISE_FACTOR * noise):
        return
    places = np.nonzero(mask)
    level, colour = _shade(picture[places], empty[places])
    shadow = (level > DEEPEST_SHADOW) & (level < 1.0) & (colour < CONTRAST_SHARE * robot)
    mask[places[0][shadow], places[1][shadow]] = 0


def _shade(seen: Image, empty: Image) -> tuple[FloatArray, FloatArray]:
    """The share (n,) of the backdrop's level that colours (n, 3) have, and their distance (n,) from that shade of it."""
    colours, backdrop = seen.astype(np.float32), empty.astype(np.float32)
    share = (colours * backdrop).sum(axis=1) / np.maximum((backdrop**2).sum(axis=1), 1.0)
    return share, np.linalg.norm(colours - share[:, None] * backdrop, axis=1)


def _component_at_base(name: str, mask: Mask, at_base: Places, px_per_mm2: float) -> Mask:
    """What hangs together with the robot's beginning, small holes (glare, dust) filled."""
    labels = np.asarray(cv2.connectedComponents(mask, connectivity=8)[1])
    touched = labels[at_base]
    touched = touched[touched > 0]
    if touched.size == 0:
        raise RefusedError(f"camera {name}: no robot is joined to its base")
    robot: Mask = (labels == np.bincount(touched).argmax()).view(np.uint8) * np.uint8(255)
    area_mm2 = np.count_nonzero(robot) / px_per_mm2
    if area_mm2 < SMALLEST_ROBOT_MM2:
        raise RefusedError(
            f"camera {name}: what stands at the base is too small for a robot "
            f"({area_mm2:.1f} mm2; at least {SMALLEST_ROBOT_MM2:g} mm2)"
        )
    x, y, width, height = cv2.boundingRect(robot)
    part = robot[y : y + height, x : x + width]
    around = np.pad(255 - part, 1, constant_values=255)
    gaps = np.asarray(cv2.connectedComponents(around, connectivity=4)[1])
    small = np.bincount(gaps.ravel()) < SMALLEST_ROBOT_MM2 * px_per_mm2
    small[gaps[0, 0]] = False
    part[small[gaps[1:-1, 1:-1]]] = 255
    return robot
