"""The robot in pictures of cameras that do not know where its base is: told from its holder, and its base from its tip.

Where the base is, is what sensing begins with. Here two other things are known: the robot's tip moves when its tendons are
pulled while its holder stays, and a holder is much wider than the tube that it holds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from messaging.checked import FloatArray
from nodal.errors import CalibrationError
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop, Distances, noise_level
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import (
    CLOSING,
    CONTRAST_SHARE,
    LEAST_DISTANCE,
    NOISE_FACTOR,
    Mask,
)
from sensing.pictures.work_area import work_area_mask
from sensing.refined.midline import half_width, midlines
from sensing.scene import Scene
from sensing.shape import Silhouette

STANDS_OUT = 99.0
"""The share of a picture, in per cent, that robot and holder do not fill at least: the rest speaks for the robot's contrast."""
SPECKS = np.ones((3, 3), np.uint8)
LEAST_MOVED = 3.0
"""The moving tip sweeps at least so many squares of the tube's width."""
WIDE = 1.7
"""Spacer disks widen a silhouette by less than this factor, and holders by more."""
LEAST_LENGTH = 4.0
"""A midline is at least so many widths long."""


@dataclass(frozen=True)
class Moving:
    """What one camera saw of the robot moving while its base stood still, in detection pixels.

    `swept` (h, w) is what was robot in some pictures and backdrop in others, `up` (2,) the unit direction from what never
    moved to what did, and `half_width_px` the tube's where it moved.
    """

    swept: Mask
    up: FloatArray
    half_width_px: float


def moving(camera: Camera, scene: Scene, pictures: Sequence[Picture]) -> Moving:
    """Compare pictures of the robot bent in several ways over the same base; raises CalibrationError when nothing moved."""
    masks = [_standing_out(camera, scene, picture)[0] for picture in pictures]
    ever, always = masks[0].copy(), masks[0].copy()
    for mask in masks[1:]:
        ever, always = ever | mask, always & mask
    swept = np.asarray(cv2.morphologyEx(ever & ~always, cv2.MORPH_OPEN, SPECKS), dtype=np.uint8)
    _, labels = cv2.connectedComponents(ever, connectivity=8)
    counts = np.bincount(labels[(swept > 0) & (labels > 0)], minlength=2)
    robot = labels == int(counts.argmax())
    swept[~robot] = 0
    still = (always > 0) & robot
    if not swept.any() or not still.any():
        raise CalibrationError(
            f"camera {camera.name}: nothing moved in its pictures when tendons were pulled"
        )
    width = float(np.median([half_width(mask & swept) for mask in masks]))
    if np.count_nonzero(swept) < LEAST_MOVED * (2 * width) ** 2:
        raise CalibrationError(
            f"camera {camera.name}: what moved when tendons were pulled is only {np.count_nonzero(swept)} px large: "
            "the robot does not bend, or is out of view"
        )
    up = _centre(swept) - _centre(np.where(still, np.uint8(255), np.uint8(0)))
    return Moving(swept, up / np.linalg.norm(up), width)


def robot_midline(
    camera: Camera, scene: Scene, picture: Picture, moved: Moving
) -> tuple[Silhouette, Backdrop]:
    """The robot's silhouette without its holder, its midline from the base on, and the backdrop that it was told from.

    Raises RefusedError when there is no such line.
    """
    mask, backdrop = _standing_out(camera, scene, picture)
    reach = max(round(WIDE * moved.half_width_px), 2)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * (reach // 2) + 3, 2 * (reach // 2) + 3))
    holder = cv2.dilate(cv2.morphologyEx(mask, cv2.MORPH_OPEN, disk), around)
    _, labels = cv2.connectedComponents(mask & ~np.asarray(holder, np.uint8), connectivity=8)
    counts = np.bincount(labels[(moved.swept > 0) & (labels > 0)], minlength=2)
    robot: Mask = np.where(labels == int(counts.argmax()), np.uint8(255), np.uint8(0))
    if not counts.any():
        raise RefusedError(f"camera {camera.name}: the robot is not where it moved before")
    rows, columns = np.nonzero(robot)
    places = np.column_stack([columns, rows]).astype(np.float64)
    height, width = places @ moved.up, half_width(robot)
    # not one pixel, which would be a corner: the middle of the lowest
    lines = midlines(robot, places[height < height.min() + width].mean(axis=0))
    if not lines or curve.arc_lengths(lines[0])[-1] < LEAST_LENGTH * 2 * width:
        raise RefusedError(f"camera {camera.name}: what moved is not as long and thin as a robot")
    grid = backdrop.grid
    return Silhouette(robot, grid.fine(lines[0]), width * grid.step), backdrop


def _standing_out(camera: Camera, scene: Scene, picture: Picture) -> tuple[Mask, Backdrop]:
    """The mask (h, w) of what differs from the backdrop, robot and holder alike, in detection pixels."""
    backdrop = scene.backdrop(picture)
    distance = backdrop.distance(picture.reduced(backdrop.grid.step))
    area = scene.work_areas.get(camera.name)
    if area is not None:
        distance[work_area_mask(area, backdrop.grid) == 0] = 0.0
    mask = np.where(distance > _threshold(distance, scene.threshold), np.uint8(255), np.uint8(0))
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, CLOSING), dtype=np.uint8), backdrop


def _threshold(distance: Distances, given: float | None) -> float:
    """Equation 1's T in levels, as `threshold_at_base` has it, with the contrast of what stands out most."""
    contrast = float(np.percentile(distance[::2, ::2], STANDS_OUT))
    return given or max(LEAST_DISTANCE, NOISE_FACTOR * noise_level(distance), CONTRAST_SHARE * contrast)


def _centre(mask: Mask) -> FloatArray:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()])
