"""The silhouette's skeleton by distance transform (METHOD step 4), as a graph of pixels.

What lies near the border cannot be skeleton, so the distance transform cuts it away first, and with it the corners from
which thinning would grow side branches; what is left is thinned to lines of one pixel (Guo and Hall 1989, "Parallel
thinning with two-subiteration algorithms", algorithm A1).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.segmentation import Mask

CORE_SHARE = 0.5
"""How deep in the silhouette, in half widths, its skeleton lies at least."""

_RING = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""The eight neighbours as (row, column), clockwise from above; a pixel's code has a bit for each that is set."""
_BITS = np.zeros((3, 3), np.float32)
for _bit, (_row, _column) in enumerate(_RING):
    _BITS[_row + 1, _column + 1] = 1 << _bit


def _kept() -> NDArray[np.uint8]:
    """For both passes of a round and each code, 1 where the pixel stays: (2, 256)."""
    ring = (np.arange(256)[:, None] >> np.arange(8) & 1).astype(bool).T
    after, before = np.roll(ring, -1, axis=0), np.roll(ring, 1, axis=0)
    sides, after_next = ring[::2], np.roll(ring, -2, axis=0)[::2]
    crossings = (~sides & (after[::2] | after_next)).sum(axis=0)
    pairs = np.minimum((before[::2] | sides).sum(axis=0), (sides | after[::2]).sum(axis=0))
    border = (crossings == 1) & (pairs >= 2) & (pairs <= 3)
    # p2 to p9 of the paper are ring 0 to 7
    held = [(ring[4] | ring[5] | ~ring[7]) & ring[6], (ring[0] | ring[1] | ~ring[3]) & ring[2]]
    return np.array([~border | hold for hold in held]).astype(np.uint8)


_KEPT = _kept()


@dataclass(frozen=True)
class Skeleton:
    """Pixels (n, 2) as (x, y), in the order in which they are reached from the one nearest to the base, along the skeleton.

    `parent` is the index of the pixel from which each was reached (the first: its own), `reach_px` (n,) the way to it,
    `neighbours` the indices of each pixel's neighbours, `depth_px` (n,) the distance to the silhouette's border, and
    `half_width_px` the silhouette's typical half width.
    """

    pixels: FloatArray
    parent: tuple[int, ...]
    reach_px: FloatArray
    neighbours: tuple[tuple[int, ...], ...]
    depth_px: FloatArray
    half_width_px: float


def skeleton(mask: Mask, base_pixel: FloatArray) -> Skeleton:
    """The skeleton of a mask (h, w) that is not empty, as far as it hangs together with its pixel nearest to the base (2,).

    Side branches shorter than the silhouette's half width are dropped.
    """
    x0, y0, width, height = cv2.boundingRect(mask)
    box = np.pad(mask[y0 : y0 + height, x0 : x0 + width], 1)
    depth = cv2.distanceTransform(box, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # across a strip the depth rises evenly from its border to its middle
    half_width = 2.0 * float(np.median(depth[depth > 0]))
    line = thinned((depth > min(CORE_SHARE * half_width, float(depth.max()) / 2)).astype(np.uint8))
    rows, columns = np.nonzero(line)
    corner = np.array([x0 - 1.0, y0 - 1.0])
    root = int(np.linalg.norm(np.column_stack([columns, rows]) + corner - base_pixel, axis=1).argmin())
    places = list(zip(rows.tolist(), columns.tolist(), strict=True))
    tree = _pruned(_Tree.grown(places, places[root]), half_width)
    rows, columns = np.array(tree.places).T
    return Skeleton(
        pixels=np.column_stack([columns, rows]) + corner,
        parent=tuple(tree.parent),
        reach_px=np.array(tree.reach),
        neighbours=tree.neighbours(),
        depth_px=depth[rows, columns].astype(np.float64),
        half_width_px=half_width,
    )


def thinned(figure: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A figure (h, w) of 0 and 1, whose rim is 0, thinned to lines of one pixel that hang together as it does."""
    before = -1
    while (now := cv2.countNonZero(figure)) != before:
        before = now
        for kept in _KEPT:
            code = cv2.filter2D(figure, cv2.CV_8U, _BITS, borderType=cv2.BORDER_CONSTANT)
            figure = np.asarray(cv2.bitwise_and(figure, cv2.LUT(code, kept)), dtype=np.uint8)
    return figure


@dataclass(frozen=True)
class _Tree:
    """Places (row, column) breadth first, each with the index of its parent and the way to it from the first."""

    places: list[tuple[int, int]]
    parent: list[int]
    reach: list[float]

    @classmethod
    def grown(cls, places: Iterable[tuple[int, int]], root: tuple[int, int]) -> "_Tree":
        """The tree of all places that hang together with the root."""
        left = set(places) - {root}
        tree = cls([root], [0], [0.0])
        for here, (row, column) in enumerate(tree.places):
            for down, right in _RING:
                place = row + down, column + right
                if place in left:
                    left.remove(place)
                    tree.places.append(place)
                    tree.parent.append(here)
                    tree.reach.append(tree.reach[here] + hypot(down, right))
        return tree

    def neighbours(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the places next to each place."""
        number = {place: index for index, place in enumerate(self.places)}
        return tuple(
            tuple(
                number[row + down, column + right]
                for down, right in _RING
                if (row + down, column + right) in number
            )
            for row, column in self.places
        )


def _pruned(tree: _Tree, least_px: float) -> _Tree:
    """The tree without branches that end less than `least_px` behind their fork; of each fork's the longest stays."""
    end = list(tree.reach)
    longest = list(range(len(end)))
    for child in range(len(end) - 1, 0, -1):
        parent = tree.parent[child]
        if end[child] > end[parent]:
            end[parent], longest[parent] = end[child], child
    kept = [True] * len(end)
    for child in range(1, len(end)):
        parent = tree.parent[child]
        long_enough = longest[parent] == child or end[child] - tree.reach[parent] >= least_px
        kept[child] = kept[parent] and long_enough
    return _Tree.grown((place for place, keep in zip(tree.places, kept, strict=True) if keep), tree.places[0])
