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
    rows, columns = gaps_mm.shape
    total = _walk_costs(gaps_mm**2 + EVENNESS_MM2)
    row, column = rows - 1, columns - 1
    walk = [(row, column)]
    while row or column:
        moves = ((row - 1, column - 1), (row - 1, column), (row, column - 1))
        row, column = min((move for move in moves if min(move) >= 0), key=lambda move: total[move])
        walk.append((row, column))
    first, second = np.array(walk[::-1]).T
    return first, second


def _walk_costs(cost: FloatArray) -> FloatArray:
    """Accumulated cost of the cheapest walk to every cell, one anti-diagonal at a time."""
    rows, columns = cost.shape
    total = np.full((rows + 1, columns + 1), np.inf)
    total[0, 0] = 0.0
    for diagonal in range(rows + columns - 1):
        i = np.arange(max(0, diagonal - columns + 1), min(rows, diagonal + 1))
        j = diagonal - i
        before = np.minimum(np.minimum(total[i, j], total[i, j + 1]), total[i + 1, j])
        total[i + 1, j + 1] = cost[i, j] + before
    return total[1:, 1:]
