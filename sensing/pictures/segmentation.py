"""Which pixels are the robot (METHOD steps 2 and 3), at detection size.

The base is where the calibration says it is, so the robot is what stands out from the backdrop there and what hangs
together with it; the threshold lies between the noise and the contrast seen at the base. Below the base, within the
holder's radius, nothing is robot: that is how the holder, which may join the silhouette, is told from it.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import SCALE, noise_level

Mask = NDArray[np.uint8]

AXIS_MM: FloatArray = np.arange(3.0, 9.0, 0.5)
"""Heights above the base at which the robot's contrast is read off its nearly straight beginning."""
CONTRAST_SHARE = 0.4
NOISE_FACTOR = 5.0
LEAST_DISTANCE = 5.0
"""Colour distance that tells nothing from the backdrop, even where the backdrop shows no noise at all."""
SMALLEST_ROBOT_PX = 150


@dataclass(frozen=True)
class BaseView:
    """Where a camera sees the base: in detection pixels, the base's place, the direction of +Z and the scale."""

    pixel: FloatArray
    axis_pixels: FloatArray
    up: FloatArray
    px_per_mm: float

    @classmethod
    def of(cls, camera: Camera, insertion_mm: float) -> "BaseView":
        """The base at this insertion."""
        heights = np.concatenate([[0.0], AXIS_MM]) + insertion_mm
        pixels = small_pixels(camera.project(np.column_stack([0 * heights, 0 * heights, heights])))
        along = pixels[-1] - pixels[0]
        length = float(np.linalg.norm(along))
        return cls(pixels[0], pixels[1:], along / length, length / AXIS_MM[-1])


def small_pixels(pixels: FloatArray) -> FloatArray:
    """Full-size pixel coordinates as detection-size ones; both count from pixel centres."""
    return (pixels + 0.5) / SCALE - 0.5


def full_pixels(pixels: FloatArray) -> FloatArray:
    """Detection-size pixel coordinates as full-size ones."""
    return (pixels + 0.5) * SCALE - 0.5


def robot_mask(name: str, distance: FloatArray, base: BaseView, holder_radius_mm: float) -> Mask:
    """The robot's pixels (255) in a colour-distance picture (h, w); raises RefusedError when there is no robot."""
    height, width = distance.shape
    columns, rows = base.axis_pixels.round().astype(int).T
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    if not inside.any():
        raise RefusedError(f"camera {name}: the robot's base is outside the picture")
    noise = noise_level(distance)
    contrast = float(np.median(distance[rows[inside], columns[inside]]))
    threshold = max(LEAST_DISTANCE, NOISE_FACTOR * noise, CONTRAST_SHARE * contrast)
    if contrast < threshold:
        raise RefusedError(
            f"camera {name}: nothing stands out from the backdrop where the robot leaves its base "
            f"(colour distance {contrast:.0f}, backdrop {noise:.0f})"
        )
    mask = np.where(distance > threshold, np.uint8(255), np.uint8(0))
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)), dtype=np.uint8)
    mask[_holder(mask.shape, base, holder_radius_mm)] = 0
    return _component_at_base(name, mask, rows[inside], columns[inside])


def _holder(shape: tuple[int, ...], base: BaseView, radius_mm: float) -> NDArray[np.bool_]:
    y, x = np.ogrid[: shape[0], : shape[1]]
    along = (x - base.pixel[0]) * base.up[0] + (y - base.pixel[1]) * base.up[1]
    across = (y - base.pixel[1]) * base.up[0] - (x - base.pixel[0]) * base.up[1]
    return np.asarray((along < 0) & (np.abs(across) < radius_mm * base.px_per_mm))


def _component_at_base(name: str, mask: Mask, rows: NDArray[np.int_], columns: NDArray[np.int_]) -> Mask:
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    touched = labels[rows, columns]
    touched = touched[touched > 0]
    if touched.size == 0:
        raise RefusedError(f"camera {name}: no robot is joined to its base")
    label = int(np.bincount(touched).argmax())
    area = int(statistics[label, cv2.CC_STAT_AREA])
    if area < SMALLEST_ROBOT_PX:
        raise RefusedError(
            f"camera {name}: what stands at the base is too small for a robot ({area * SCALE**2} px)"
        )
    return np.where(labels == label, np.uint8(255), np.uint8(0))
