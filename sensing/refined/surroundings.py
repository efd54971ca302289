"""Whether a fitted tube is where the robot is: its inside is not backdrop, and around it there is no more robot.

Edges alone do not tell. A curve that turns towards a camera has none there, and a fit likes to turn where nothing
contradicts it; whatever else the camera sees of the robot then lies outside of the tube.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.geometry.vectors import lengths, median
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import BaseView
from sensing.refined.edges import LEAST_CONTRAST, Walk, contrast
from sensing.refined.measuring import View
from sensing.refined.track import Track
from sensing.refined.tube import sides

RIM = 1.3
"""Spacer disks stand out by no more than this share of the tube's radius."""
CLEAR_MM = 1.0
"""How far beyond that the surroundings are looked at."""
RING: FloatArray = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
SHARE_OF_CONTRAST = 0.45
"""What differs from the backdrop by this share of what the tube typically does is robot."""
SHARE_AT_BASE = 0.3
"""And by this share of what it does where it leaves its base: there the robot is, wherever the rest of the tube lies."""
BASE_SAMPLES = slice(curve.SAMPLES // 25, curve.SAMPLES // 8)
AT_BASE_MM = 5.0
"""So near to its base a tube's surroundings may show the holder."""
_AROUND_END = np.column_stack([np.cos(RING), np.sin(RING)])


@dataclass(frozen=True)
class Surroundings:
    """In one camera: which of n places along the centreline show backdrop, and which of k places around the tube robot.

    The first n of those lie to one side of the tube, the next n to the other, the rest in a ring around its end.
    """

    missing: NDArray[np.bool_]
    spilled: NDArray[np.bool_]


def look_around(views: tuple[View, ...], track: Track, holder_radius_mm: float) -> tuple[Surroundings, ...]:
    """What each camera sees in and around a fitted tube; the holder below the base does not count."""
    edges = sides(np.array([view.camera.centre_mm for view in views]), track.curve)
    places = np.concatenate([edges.one, edges.other], axis=1)
    return tuple(
        _seen(view, view.camera.project(there), track, holder_radius_mm)
        for view, there in zip(views, places, strict=True)
    )


def _seen(view: View, edges_px: FloatArray, track: Track, holder_radius_mm: float) -> Surroundings:
    fitted, count = track.curve, curve.SAMPLES
    one, other = edges_px[:count], edges_px[count:]
    middle, across = (one + other) / 2, (one - other) / 2
    half = lengths(across)[:, 0]
    away = RIM + CLEAR_MM / fitted.radius_mm
    beside = away[:, None] * across
    outside = np.concatenate(
        [middle + beside, middle - beside, middle[-1] + away[-1] * half[-1] * _AROUND_END]
    )
    difference = _contrast(view, np.concatenate([middle, outside]))
    shown = view.shows(middle)
    typical = float(median(difference[:count][shown])) if shown.any() else 0.0
    at_base = float(median(difference[:count][BASE_SAMPLES]))
    level = max(SHARE_OF_CONTRAST * abs(typical), SHARE_AT_BASE * abs(at_base), LEAST_CONTRAST)
    robot = np.sign(typical if abs(typical) > level else at_base) * difference > level
    spilled = robot[count:]
    spilled[: 2 * count] &= np.tile(curve.PARAMETER * fitted.length_mm > AT_BASE_MM, 2)
    for place in np.flatnonzero(spilled):
        spilled[place] = (lengths(middle - outside[place])[:, 0] > RIM * half + 1.0).all()
    if spilled.any():
        holder = _holder(view.camera, track.insertion_mm, holder_radius_mm)
        for place in np.flatnonzero(spilled):
            spilled[place] = cv2.pointPolygonTest(holder, outside[place].tolist(), measureDist=False) < 0
    return Surroundings(shown & ~robot[:count], spilled)


def _contrast(view: View, pixels: FloatArray) -> NDArray[np.float32]:
    """Contrast (n,) at single pixels (n, 2) of the whole picture."""
    here = Walk(np.zeros((len(pixels), 1), np.float32), np.ones(len(pixels)))
    return contrast(view.picture, view.backdrop, pixels - view.corner, np.zeros_like(pixels), here)[:, 0]


def _holder(camera: Camera, insertion_mm: float, radius_mm: float) -> NDArray[np.float32]:
    """Corners (4, 2) in px of the strip where the holder stands."""
    strip = BaseView.of(camera, insertion_mm).below(radius_mm, float(sum(camera.size_px)))
    return np.asarray(Grid.of(camera.size_px).fine(strip), dtype=np.float32)
