"""Which pixel of one midline belongs to which of the other (METHOD step 5), and where they lie (steps 6 and 8).

Pairing each pixel by itself with the smallest ray gap jumps wherever the epipolar line meets the curve twice. Here both
midlines are walked from base to tip and the walk with the smallest sum of squared gaps is taken (dynamic programming):
order is preserved, and where the gap says nothing the walk goes on evenly.
"""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.camera import Camera

EVENNESS_MM2 = 1e-3
"""Cost of one step of the walk: prefers few, even steps where the gap cannot choose."""


def ray_gaps(first: Camera, first_rays: FloatArray, second: Camera, second_rays: FloatArray) -> FloatArray:
    """Gaps (n, m) in mm between rays (n, 3) of one camera and rays (m, 3) of another."""
    normal = np.cross(first_rays[:, None, :], second_rays[None, :, :])
    length = np.linalg.norm(normal, axis=2)
    baseline = second.centre_mm - first.centre_mm
    return np.asarray(np.abs(normal @ baseline) / np.maximum(length, 1e-12))


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


def triangulate(
    first: Camera, first_rays: FloatArray, second: Camera, second_rays: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points (n, 3) midway between paired rays, each (n, 3), and the gaps (n,) between the rays, in mm."""
    across = second.centre_mm - first.centre_mm
    dot = np.einsum("ij,ij->i", first_rays, second_rays)
    along_first, along_second = first_rays @ across, second_rays @ across
    sine2 = np.maximum(1.0 - dot**2, 1e-12)
    reach_first = (along_first - dot * along_second) / sine2
    reach_second = (dot * along_first - along_second) / sine2
    near_first = first.centre_mm + reach_first[:, None] * first_rays
    near_second = second.centre_mm + reach_second[:, None] * second_rays
    return (near_first + near_second) / 2, np.linalg.norm(near_first - near_second, axis=1)
