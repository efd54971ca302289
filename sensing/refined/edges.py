"""The silhouette's two edges along short normals, to a fraction of a pixel (in place of METHOD step 4's skeleton pixels).

Brightness is read along normals of the predicted midline. Walking outwards from the middle, an edge lies where the
contrast falls through half of its height; the height is then taken anew from a few pixels inside and outside of that
place, because shading makes the tube's two sides differ. Of a side that stands out far less than the whole tube, that
place may lie within the tube, so its edge is sought once more by its own contrast. A spacer disk widens the silhouette on
both sides alike and leaves the middle.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.geometry.vectors import median
from sensing.pictures.light import LINEAR, Image

SPACING_PX = 0.8
"""Along normals brightness is read at least as densely as this."""
MOST_SAMPLES = 400
"""A tube that is wider than this allows is read less densely; so is what a fit that went astray takes for one."""
LEAST_MARGIN_PX = 6.0
LEAST_CONTRAST = 3.0
"""Linear brightness, out of 255, by which the robot must differ from the backdrop at an edge."""
BLUR_PX = 2.5
"""An edge is blurred over no more than this to either side."""
LIT = 0.7
"""A side that stands out by a smaller share of the whole tube's contrast is looked at again, by its own."""
NEARBY = 6
"""The local half height is met within so many samples of the first crossing."""

_LIGHT = LINEAR.astype(np.float32)
"""Linear light of each level: a lens mixes light, not levels, so half an edge's height is half of its light."""


@dataclass(frozen=True)
class EdgePair:
    """Edges along n normals: signed distances of the middle from the predicted one, half widths (px), and which count."""

    middle_px: FloatArray
    half_width_px: FloatArray
    valid: NDArray[np.bool_]


@dataclass(frozen=True)
class Walk:
    """Where brightness is read along n lines: at offsets (n, m) px from places of theirs, evenly `step` (n,) px apart."""

    offsets: NDArray[np.float32]
    step: FloatArray

    @classmethod
    def across(cls, half_widths: FloatArray, margin_px: FloatArray) -> "Walk":
        """To both sides of a middle, beyond the predicted half widths (n,) by a margin (n,); odd in number."""
        reach = 1.1 * half_widths + np.maximum(margin_px, LEAST_MARGIN_PX)
        half = _samples(reach)
        step = reach / half
        return cls(np.multiply.outer(step, np.arange(-half, half + 1)).astype(np.float32), step)

    @classmethod
    def onwards(cls, reach_px: FloatArray) -> "Walk":
        """From a place as far as `reach_px` (n,); twice as dense, since lines onwards are few."""
        count = 2 * _samples(reach_px)
        step = reach_px / count
        return cls(np.multiply.outer(step, np.arange(count + 1)).astype(np.float32), step)

    def part(self, rows: slice) -> "Walk":
        """Some of the lines."""
        return Walk(self.offsets[rows], self.step[rows])


def _samples(reach_px: FloatArray) -> int:
    return int(min(np.ceil(reach_px.max(initial=SPACING_PX) / SPACING_PX), MOST_SAMPLES))


def contrast(
    picture: Image, backdrop: Image, start: FloatArray, direction: FloatArray, walk: Walk
) -> NDArray[np.float32]:
    """Backdrop minus picture in linear light (n, m) along walks from places (n, 2) in unit directions (n, 2).

    Places are (x, y) in px; between pixels it is bilinear, beyond the picture that of its rim.
    """
    at, towards = start.astype(np.float32), direction.astype(np.float32)
    x, y = (at[:, axis, None] + walk.offsets * towards[:, axis, None] for axis in (0, 1))
    seen, empty = (
        cv2.remap(source, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for source in (picture, backdrop)
    )
    return np.asarray(_LIGHT[empty] - _LIGHT[seen])


def edge_pairs(profile: NDArray[np.float32], walk: Walk, half_widths: FloatArray) -> EdgePair:
    """The edges in contrast (n, m) along walks across tubes of these predicted half widths (n,) in px."""
    half = profile.shape[1] // 2
    inside = np.abs(walk.offsets) < (0.5 * half_widths[:, None]).astype(np.float32)
    height = np.sum(profile * inside, axis=1) / np.maximum(np.count_nonzero(inside, axis=1), 1)
    profile = profile * np.sign(height[:, None]).astype(np.float32)
    outwards = np.concatenate([profile[:, half:], profile[:, half::-1]])
    blur = np.minimum(BLUR_PX, 0.25 * half_widths)
    distance, found = _edge(outwards, np.abs(height), walk.step, blur)
    (right, left), seen = distance.reshape(2, -1), found.reshape(2, -1).all(axis=0)
    return EdgePair((right - left) / 2, (right + left) / 2, seen & (np.abs(height) > LEAST_CONTRAST))


def ends(profile: NDArray[np.float32], walk: Walk) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Distances (n,) in px to the silhouette's end in contrast (n, m) along walks onwards, and which were seen."""
    height = median(profile[:, : max(profile.shape[1] // 6, 1)])
    blur = np.full(len(profile), BLUR_PX)
    distance, found = _edge(
        profile * np.sign(height[:, None]).astype(np.float32), np.abs(height), walk.step, blur
    )
    return distance, found & (np.abs(height) > LEAST_CONTRAST)


def _edge(
    profile: NDArray[np.float32], height: FloatArray, step: FloatArray, blur: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Distance (n,) from the first column at which profiles (n, m) fall through half of their local height.

    Heights, steps and blurs are those of the first so many profiles, and of as many again if there are more.
    """
    height, step, blur = (np.resize(each, len(profile)) for each in (height, step, blur))
    fall = _Fall.at(profile, height, step, blur)
    lit = np.flatnonzero(fall.found & (fall.inside < LIT * height))
    if len(lit):
        fall.put(lit, _Fall.at(profile[lit], fall.inside[lit], step[lit], blur[lit]))
    return fall.column * step, fall.found


@dataclass(frozen=True)
class _Fall:
    """Where n profiles fall through half of their local height: columns, contrasts just inside, and which do."""

    column: FloatArray
    inside: FloatArray
    found: NDArray[np.bool_]

    @classmethod
    def at(
        cls, profile: NDArray[np.float32], height: FloatArray, step: FloatArray, blur: FloatArray
    ) -> "_Fall":
        """Next to the first place at which profiles (n, m) fall through half of these heights (n,)."""
        rows = np.arange(len(profile))
        below = profile < (0.5 * height[:, None]).astype(np.float32)
        first = below.argmax(axis=1)
        last = profile.shape[1] - 1
        reach = np.maximum((blur / step).astype(int), 1)
        found = below[rows, first] & (first > reach) & (first < last)
        first = np.minimum(np.maximum(first, 1), last)
        columns = first[:, None] + np.multiply.outer(reach, [-2.0, -1.5, 1.5, 2.0]).astype(int)
        levels = profile[rows[:, None], np.minimum(np.maximum(columns, 0), last)]
        level = levels.sum(axis=1) / levels.shape[1]
        # of the places nearby where the profile falls through this level, the one next to the first crossing
        window = np.minimum(np.maximum(first[:, None] + np.arange(-NEARBY, NEARBY + 1), 0), last)
        nearby = profile[rows[:, None], window]
        above = nearby >= level[:, None]
        crossing = above[:, :-1] & ~above[:, 1:]
        chosen = np.where(crossing, _AWAY, np.inf).argmin(axis=1)
        found &= crossing[rows, chosen]
        high, low = nearby[rows, chosen], nearby[rows, chosen + 1]
        fraction = (high - level) / np.where(high > low, high - low, 1.0)
        return cls(window[rows, chosen] + fraction, levels[:, :2].mean(axis=1), found)

    def put(self, rows: NDArray[np.intp], others: "_Fall") -> None:
        """Others in the place of these rows."""
        self.column[rows], self.found[rows] = others.column, others.found


_AWAY = np.abs(np.arange(-NEARBY, NEARBY) + 0.5)
