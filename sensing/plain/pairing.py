"""Which pixel of one skeleton belongs to which of the other (METHOD step 5), by descent along the skeleton.

The walk goes to whichever neighbouring pixel's ray passes nearer to the fixed one, until none does. Where a curve turns
along the epipolar direction there are two minima, and a descent may take the wrong one: that is the method's own fault,
and `judging` looks for its traces.
"""

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.plain.skeleton import Skeleton

Pairs = NDArray[np.int_]


def descended(gaps_mm: FloatArray, walked: Skeleton, other: Skeleton) -> list[int]:
    """For each of n pixels of one skeleton the index of its partner among m of the other, by ray gaps (n, m).

    Each descent starts where that of the pixel before ended; the first, which is nearest to the base, where the other
    skeleton is nearest to the base.
    """
    found: list[int] = []
    for pixel, gaps in enumerate(gaps_mm.tolist()):
        at = found[walked.parent[pixel]] if pixel else 0
        while (next_at := min(other.near[at], key=gaps.__getitem__, default=at)) != at:
            if gaps[next_at] >= gaps[at]:
                break
            at = next_at
        found.append(at)
    return found


def all_pairs(gaps_mm: FloatArray, first: Skeleton, second: Skeleton) -> Pairs:
    """Pairs (k, 2) of indices: every pixel of the first with its partner, and every pixel of the second; none twice."""
    forwards = enumerate(descended(gaps_mm, first, second))
    backwards = ((partner, pixel) for pixel, partner in enumerate(descended(gaps_mm.T, second, first)))
    return np.array(sorted({*forwards, *backwards}))
