"""The silhouette's two edges along short normals, to a fraction of a pixel (in place of METHOD step 4's skeleton pixels).

Brightness is read along normals of the predicted midline. Walking outwards from the middle, an edge lies where the
contrast falls through half of its height; the height is then taken anew from a few pixels inside and outside of that
place, because shading makes the tube's two sides differ. A spacer disk widens both sides alike and leaves the middle.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.backdrop import Image

HALF_SAMPLES = 36
MARGIN_PX = 14.0
"""How far beyond the predicted edges normals reach."""
LEAST_CONTRAST = 3.0
"""Linear brightness, out of 255, by which the robot must differ from the backdrop at an edge."""

_CODE = np.arange(256) / 255.0
LINEAR: FloatArray = 255.0 * np.where(_CODE <= 0.04045, _CODE / 12.92, ((_CODE + 0.055) / 1.055) ** 2.4)
"""Linear light of each 8-bit level (sRGB, IEC 61966-2-1): a lens mixes light, not levels, so half an edge's height is
half of its light."""


@dataclass(frozen=True)
class EdgePair:
    """Edges along n normals: signed distances of the middle from the predicted one, half widths (px), and which count."""

    middle_px: FloatArray
    half_width_px: FloatArray
    valid: NDArray[np.bool_]


def contrast(picture: Image, backdrop: Image, places: FloatArray) -> FloatArray:
    """Backdrop minus picture in linear light at places (..., 2) given as (x, y) px, bilinearly; 0 outside of the picture."""
    x, y = (places[..., axis].astype(np.float32) for axis in (0, 1))
    seen, empty = (
        cv2.remap(source, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for source in (picture, backdrop)
    )
    return np.asarray((LINEAR[empty] - LINEAR[seen]).reshape(x.shape))


def edge_pairs(
    picture: Image, backdrop: Image, middles: FloatArray, normals: FloatArray, half_widths: FloatArray
) -> EdgePair:
    """Edges along unit normals (n, 2) through predicted middles (n, 2), near predicted half widths (n,) in px."""
    step = (1.1 * half_widths + MARGIN_PX) / HALF_SAMPLES
    offsets = np.arange(-HALF_SAMPLES, HALF_SAMPLES + 1) * step[:, None]
    profile = contrast(picture, backdrop, middles[:, None, :] + offsets[..., None] * normals[:, None, :])
    inner = np.abs(offsets) < 0.5 * half_widths[:, None]
    height = np.sum(profile * inner, axis=1) / np.maximum(inner.sum(axis=1), 1)
    profile = profile * np.sign(height)[:, None]
    outwards = np.vstack([profile[:, HALF_SAMPLES:], profile[:, HALF_SAMPLES::-1]])
    distance, found = _edge(outwards, np.tile(np.abs(height), 2), np.tile(step, 2))
    (right, left), seen = distance.reshape(2, -1), found.reshape(2, -1).all(axis=0)
    return EdgePair((right - left) / 2, (right + left) / 2, seen & (np.abs(height) > LEAST_CONTRAST))


def ends(
    picture: Image, backdrop: Image, starts: FloatArray, directions: FloatArray, reach_px: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Distances (n,) in px from `starts` (n, 2) along unit `directions` (n, 2) to the silhouette's end, and which were seen."""
    step = reach_px / (2 * HALF_SAMPLES)
    offsets = np.arange(2 * HALF_SAMPLES + 1) * step[:, None]
    profile = contrast(picture, backdrop, starts[:, None, :] + offsets[..., None] * directions[:, None, :])
    height = np.median(profile[:, : HALF_SAMPLES // 3], axis=1)
    distance, found = _edge(profile * np.sign(height)[:, None], np.abs(height), step)
    return distance, found & (np.abs(height) > LEAST_CONTRAST)


def _edge(profile: FloatArray, height: FloatArray, step: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Distance (n,) from the first column at which profiles (n, m) fall through half of their local height."""
    rows = np.arange(len(profile))
    below = profile < 0.5 * height[:, None]
    first = below.argmax(axis=1)
    last = profile.shape[1] - 1
    reach = np.maximum((2.5 / step).astype(int), 1)
    found = below.any(axis=1) & (first > reach) & (first < last)
    first = np.clip(first, 1, last)
    inside = _mean_of_two(profile, rows, first - 2 * reach, first - reach - reach // 2)
    outside = _mean_of_two(profile, rows, first + reach + reach // 2, first + 2 * reach)
    level = (inside + outside) / 2
    # the local level is met within a few pixels of the first crossing: take the last sample above it, seen from outside
    window = np.clip(first[:, None] + np.arange(-6, 7), 0, last)
    nearby = profile[rows[:, None], window]
    crossing = (nearby[:, :-1] >= level[:, None]) & (nearby[:, 1:] < level[:, None])
    distance = np.where(crossing, np.abs(np.arange(-6, 6) + 0.5), np.inf)
    chosen = distance.argmin(axis=1)
    found &= crossing.any(axis=1)
    high, low = nearby[rows, chosen], nearby[rows, chosen + 1]
    fraction = (high - level) / np.where(high > low, high - low, 1.0)
    return (window[rows, chosen] + fraction) * step, found


def _mean_of_two(
    profile: FloatArray, rows: NDArray[np.int_], one: NDArray[np.int_], other: NDArray[np.int_]
) -> FloatArray:
    last = profile.shape[1] - 1
    return (profile[rows, np.clip(one, 0, last)] + profile[rows, np.clip(other, 0, last)]) / 2
