"""Which pixel of one midline belongs to which of the other (METHOD step 5, its order kept).

Pairing each pixel by itself with the smallest ray gap jumps wherever the epipolar line meets the curve twice. Here both
midlines are walked from base to tip and the walk with the smallest sum of squared gaps is taken (dynamic programming):
order is preserved, and where the gap says nothing the walk goes on evenly.
"""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray

EVENNESS_MM2 = 1e-3
"""Cost of one step of the walk: prefers few, even steps where the gap cannot choose."""


def ordered_pairs(gaps_mm: FloatArray) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Indices of the pairs along the cheapest monotone walk from (0, 0) to (n-1, m-1) through gaps (n, m)."""
    total = _walk_costs(gaps_mm**2 + EVENNESS_MM2).tolist()
    row, column = len(total) - 1, len(total[0]) - 1
    walk = [(row, column)]
    while row or column:
        moves = ((row - 1, column - 1), (row - 1, column), (row, column - 1))
        row, column = min((move for move in moves if min(move) >= 0), key=lambda at: total[at[0]][at[1]])
        walk.append((row, column))
    first, second = np.array(walk[::-1]).T
    return first, second


def _walk_costs(cost: FloatArray) -> FloatArray:
    """Accumulated cost (n, m) of the cheapest walk to every cell, one anti-diagonal at a time.

    Row d of `slanted` holds the cells i + j = d at their i, so that a step back is to one of the two rows before.
    """
    rows, columns = cost.shape
    i, j = np.indices(cost.shape)
    slanted = np.full((rows + columns - 1, rows), np.inf)
    slanted[i + j, i] = cost
    before = np.full(rows + 1, np.inf)
    before_that = np.full(rows + 1, np.inf)
    before_that[0] = 0.0
    for diagonal in range(len(slanted)):
        slanted[diagonal] += np.minimum(np.minimum(before[:-1], before[1:]), before_that[:-1])
        before, before_that = np.concatenate([[np.inf], slanted[diagonal]]), before
    return np.asarray(slanted[i + j, i])
