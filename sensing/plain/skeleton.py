"""The silhouette's skeleton by distance transform (METHOD step 4), as a graph of pixels.

What lies near the border cannot be skeleton, so the distance transform cuts it away first, and with it the corners from
which thinning would grow side branches; what is left is thinned to lines of one pixel.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.pictures.segmentation import Mask
from sensing.pictures.thinning import thinned

CORE_SHARE = 0.5
"""How deep in the silhouette, in half widths, its skeleton lies at least."""
NEAR_SHARE = 0.5
"""As far along the skeleton, in half widths, pixels are neighbours: disks make steps to the side in it, and over one of
those the next pixel tells nothing.
"""
BRANCH_SHARE = 0.5
"""How much of a branch's length must lie beyond the circle where it begins: of a corner's 0.3 does, of a robot's all."""

_RING = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""The eight neighbours as (row, column), clockwise from above."""


@dataclass(frozen=True)
class Skeleton:
    """Pixels (n, 2) as (x, y), in the order in which they are reached from the one nearest to the base, along the skeleton.

    `parent` is the index of the pixel from which each was reached (the first: its own), `reach_px` (n,) the way to it,
    `near` the indices of the pixels near each (NEAR_SHARE), `depth_px` (n,) the distance to the silhouette's border, and
    `half_width_px` the silhouette's typical half width.
    """

    pixels: FloatArray
    parent: tuple[int, ...]
    reach_px: FloatArray
    near: tuple[tuple[int, ...], ...]
    depth_px: FloatArray
    half_width_px: float


def skeleton(mask: Mask, base_pixel: FloatArray) -> Skeleton:
    """The skeleton of a mask (h, w) that is not empty, as far as it hangs together with its pixel nearest to the base (2,).

    Side branches that corners and spacer disks make are dropped.
    """
    x0, y0, width, height = cv2.boundingRect(mask)
    box = np.pad(mask[y0 : y0 + height, x0 : x0 + width], 1)
    depth = np.asarray(cv2.distanceTransform(box, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), dtype=np.float64)
    # across a strip the depth rises evenly from its border to its middle
    half_width = 2.0 * float(np.median(depth[depth > 0]))
    core = depth > min(CORE_SHARE * half_width, float(depth.max()) / 2)
    rows, columns = np.nonzero(thinned(np.where(core, np.uint8(255), np.uint8(0))))
    corner = np.array([x0 - 1.0, y0 - 1.0])
    root = int(np.linalg.norm(np.column_stack([columns, rows]) + corner - base_pixel, axis=1).argmin())
    places = list(zip(rows.tolist(), columns.tolist(), strict=True))
    tree = _pruned(_Tree.grown(places, places[root]), depth)
    rows, columns = np.array(tree.places).T
    return Skeleton(
        pixels=np.column_stack([columns, rows]) + corner,
        parent=tuple(tree.parent),
        reach_px=np.array(tree.reach),
        near=_within(round(NEAR_SHARE * half_width) + 1, tree.neighbours()),
        depth_px=depth[rows, columns],
        half_width_px=half_width,
    )


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

    def neighbours(self) -> list[list[int]]:
        """Indices of the places next to each place."""
        number = {place: index for index, place in enumerate(self.places)}
        beside = [[(row + down, column + right) for down, right in _RING] for row, column in self.places]
        return [[number[place] for place in places if place in number] for places in beside]


def _within(steps: int, neighbours: list[list[int]]) -> tuple[tuple[int, ...], ...]:
    """For each of a graph's nodes those that are at most so many steps away, without itself."""
    near = []
    for node, beside in enumerate(neighbours):
        reached, rim = {node, *beside}, beside
        for _ in range(steps - 1):
            rim = [other for here in rim for other in neighbours[here] if other not in reached]
            reached.update(rim)
        near.append(tuple(sorted(reached - {node})))
    return tuple(near)


def _pruned(tree: _Tree, depth_px: FloatArray) -> _Tree:
    """The tree without what corners and disks add to it, `depth_px` (h, w) being the silhouette's distance transform.

    From wherever it begins, a branch must reach beyond the circle there that just fits into the silhouette.
    """
    depth = [float(depth_px[place]) for place in tree.places]
    end = list(range(len(depth)))
    for child in range(len(depth) - 1, 0, -1):
        parent = tree.parent[child]
        if tree.reach[end[child]] > tree.reach[end[parent]]:
            end[parent] = end[child]
    kept = [True] * len(depth)
    for child in range(1, len(depth)):
        parent = tree.parent[child]
        length = tree.reach[end[child]] - tree.reach[parent]
        beyond = length + depth[end[child]] - depth[parent]
        kept[child] = kept[parent] and beyond > BRANCH_SHARE * length
    return _Tree.grown((place for place, keep in zip(tree.places, kept, strict=True) if keep), tree.places[0])
