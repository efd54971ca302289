"""The silhouette's midline from base to tip (METHOD step 4).

The skeleton is the cheapest path along the ridge of the distance transform, from the base to the silhouette's far end:
one ordered line without side branches, which a thinned skeleton is not.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.segmentation import Mask

NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))


def midline(mask: Mask, base_pixel: FloatArray) -> FloatArray:
    """Pixels (n, 2) as (x, y) of the midline of a mask (h, w), ordered from the one nearest the base to the tip."""
    from scipy.sparse import csr_array  # noqa: PLC0415  slow to import, and only a cold start needs it
    from scipy.sparse.csgraph import dijkstra  # noqa: PLC0415

    x0, y0, width, height = cv2.boundingRect(mask)
    box = np.pad(mask[y0 : y0 + height, x0 : x0 + width], 1)
    depth = cv2.distanceTransform(box, cv2.DIST_L2, 5)
    number = np.full(box.shape, -1)
    rows, columns = np.nonzero(box)
    number[rows, columns] = np.arange(len(rows))
    cost = (float(depth.max()) / depth[rows, columns]) ** 3
    edges = [_edges(number, rows, columns, step) for step in NEIGHBOURS]
    tail, head = (np.concatenate([edge[side] for edge in edges]) for side in (0, 1))
    length = np.concatenate([edge[2] for edge in edges])
    shape = (len(rows), len(rows))
    near = csr_array((length, (tail, head)), shape=shape)
    ridge = csr_array((length * (cost[tail] + cost[head]), (tail, head)), shape=shape)

    pixels = np.column_stack([columns + x0 - 1, rows + y0 - 1]).astype(np.float64)
    start = int(np.linalg.norm(pixels - base_pixel, axis=1).argmin())
    away = dijkstra(near, directed=False, indices=start)
    tip = int(np.where(np.isfinite(away), away, -1.0).argmax())
    _, before = dijkstra(ridge, directed=False, indices=start, return_predecessors=True)
    path = [tip]
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    return pixels[path[::-1]]


def half_width(mask: Mask) -> float:
    """The silhouette's typical half width in px: the median depth of the mask's ridge."""
    depth = cv2.distanceTransform(mask, cv2.DIST_L2, 5)
    ridge = depth[(depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8))) & (depth > 1)]
    return float(np.median(ridge)) if ridge.size else 1.0


def _edges(
    number: NDArray[np.int_], rows: NDArray[np.int_], columns: NDArray[np.int_], step: tuple[int, int]
) -> tuple[NDArray[np.int_], NDArray[np.int_], FloatArray]:
    other = number[rows + step[0], columns + step[1]]
    joined = other >= 0
    tail = number[rows, columns][joined]
    return tail, other[joined], np.full(len(tail), float(np.hypot(*step)))
