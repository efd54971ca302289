"""A first curve where one camera sees the robot fold over itself, from another that does not.

There the folded silhouette has no midline to pair with. The other camera's midline is followed along its rays: at every
pixel all depths are tried, and of all ways through them the one is taken that stays inside of the silhouettes and moves
least to and fro (dynamic programming).
"""

from collections.abc import Sequence

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import Mask

DEPTH_MM = 1.0
"""Depths tried along a ray are this far apart."""
MOST_OUTSIDE = 3.0
"""What is this many half widths outside of a silhouette is as wrong as what is farther out."""
AWAY_FROM_MIDDLE = 0.3
"""How wrong it is to be at a silhouette's border, over being one half width outside of it."""
PER_MM = 0.15
"""How wrong it is to move a millimetre along the rays, in the same measure."""


def unfolded(
    camera: Camera,
    line_px: FloatArray,
    masks: Sequence[tuple[Camera, Mask]],
    base_mm: FloatArray,
    reach_mm: float,
) -> FloatArray:
    """Points (n, 3) on the rays through a camera's midline (n, 2), within reach of the base and inside of the other masks."""
    rays = camera.rays(line_px)
    nearest = (base_mm - camera.centre_mm) @ rays.T
    depths = np.arange(-reach_mm, reach_mm + DEPTH_MM, DEPTH_MM)
    places = camera.centre_mm + (nearest[:, None] + depths)[..., None] * rays[:, None]
    wrong = sum((_outside(*seen, places.reshape(-1, 3)) for seen in masks), np.zeros(places[..., 0].size))
    wrong = wrong.reshape(places.shape[:2])
    wrong[0] += PER_MM * np.linalg.norm(places[0] - base_mm, axis=1)
    along = nearest[:, None] + depths
    total, came = wrong[0], []
    for before, now, cost in zip(along[:-1], along[1:], wrong[1:], strict=True):
        moves = total[:, None] + PER_MM * np.abs(before[:, None] - now)
        came.append(moves.argmin(axis=0))
        total = cost + moves.min(axis=0)
    at = [int(total.argmin())]
    for step in reversed(came):
        at.append(int(step[at[-1]]))
    return np.asarray(places[np.arange(len(places)), at[::-1]])


def _outside(camera: Camera, mask: Mask, places_mm: FloatArray) -> FloatArray:
    """How wrong (n,) it is to be at places (n, 3) for a silhouette (h, w)."""
    inner, outer = (cv2.distanceTransform(side, cv2.DIST_L2, 3) for side in (mask, 255 - mask))
    half_width = max(float(np.median(inner[inner > 0.7 * inner.max()])), 1.0)
    measure = np.minimum(outer / half_width, MOST_OUTSIDE) + AWAY_FROM_MIDDLE * (
        1 - np.minimum(inner / half_width, 1.0)
    )
    pixels = Grid.of(camera.size_px).coarse(camera.project(places_mm)).astype(np.float32)
    seen = cv2.remap(
        measure.astype(np.float32),
        pixels[:, :1],
        pixels[:, 1:],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=MOST_OUTSIDE,
    )
    return np.asarray(seen.ravel(), dtype=np.float64)
