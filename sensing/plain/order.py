"""Triangulated points in the order of the centreline (METHOD step 8)."""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray

ASIDE = 0.2
"""How far beside the line a point may lie that ends it, in radii."""


def ordered(points_mm: FloatArray, apart_mm: float) -> NDArray[np.int_]:
    """Indices of points (n, 3), n > 0, along the line: from the smallest Z always on to the nearest that remains.

    A point within `apart_mm` of one that was taken is a duplicate of it, and dropped.
    """
    remaining = np.arange(len(points_mm))
    taken = [int(points_mm[:, 2].argmin())]
    while True:
        away = np.linalg.norm(points_mm[remaining] - points_mm[taken[-1]], axis=1)
        remaining, away = remaining[away > apart_mm], away[away > apart_mm]
        if not remaining.size:
            return np.array(taken)
        taken.append(int(remaining[away.argmin()]))


def end_of_line(points_mm: FloatArray, taken: NDArray[np.int_], apart_mm: float) -> int:
    """The index of the point that ends a line through `taken` (n,), n > 1: of the last one's duplicates the farthest ahead.

    One that lies aside has been paired wrongly and ends nothing.
    """
    onwards = points_mm[taken[-1]] - points_mm[taken[-2]]
    onwards = onwards / np.linalg.norm(onwards)
    beyond = points_mm - points_mm[taken[-1]]
    ahead = beyond @ onwards
    aside = np.linalg.norm(beyond - ahead[:, None] * onwards, axis=1)
    usable = (np.linalg.norm(beyond, axis=1) <= apart_mm) & (aside <= ASIDE * apart_mm)
    return int(np.where(usable, ahead, -np.inf).argmax())
