"""Triangulated points in the order of the centreline (METHOD step 8)."""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray


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
