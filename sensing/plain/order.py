"""Triangulated points in the order of the centreline (METHOD step 8)."""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray


def ordered(points_mm: FloatArray, apart_mm: float) -> NDArray[np.int_]:
    """Indices of points (n, 3) along the line: from the smallest Z always on to the nearest that remains.

    A point within `apart_mm` of one that was taken is a duplicate of it, and dropped. Of the last one's duplicates the
    farthest out stands in for it, so that the line does not end early.
    """
    remaining = np.arange(len(points_mm))
    taken = [int(points_mm[:, 2].argmin())]
    while True:
        away = np.linalg.norm(points_mm[remaining] - points_mm[taken[-1]], axis=1)
        near, remaining = remaining[away <= apart_mm], remaining[away > apart_mm]
        if not remaining.size:
            break
        taken.append(int(remaining[away[away > apart_mm].argmin()]))
    if len(taken) > 1:
        beyond = np.linalg.norm(points_mm[near] - points_mm[taken[-2]], axis=1)
        taken[-1] = int(near[beyond.argmax()])
    return np.array(taken)
