"""Where a lens is sharpest, sought from coarse to fine."""

import math
from collections.abc import Callable, Mapping

INTERVALS = 10
"""Each round divides what is left by so many."""
FLAT_PX = 0.05
"""Edges that differ by less in width are as sharp as one another: noise does as much."""


def sweep(width_px: Callable[[int], float], first: int, last: int, step: int) -> dict[int, float]:
    """How wide edges are at each focus that was tried, first over the whole range, then ever finer around what is sharp, down to
    `step` or a part of what is.

    `width_px` takes pictures at a focus; it is infinite where there are no edges, and where there are none at all the first
    round is the last.
    """
    tried: dict[int, float] = {}
    low, high, before = first, last, last - first + 1
    while (spacing := max(round((high - low) / INTERVALS / step), 1) * step) < before:
        for focus in range(low, high + 1, spacing):
            if focus not in tried:
                tried[focus] = width_px(focus)
        flat = _sharp(tried)
        if math.isinf(tried[flat[0]]):
            break
        low, high, before = max(flat[0] - spacing, first), min(flat[-1] + spacing, last), spacing
    return tried


def sharpest(tried: Mapping[int, float]) -> int:
    """The middle of those at which edges are narrowest."""
    flat = _sharp(tried)
    return min(flat, key=lambda focus: abs(focus - (flat[0] + flat[-1]) / 2))


def _sharp(tried: Mapping[int, float]) -> list[int]:
    """Those at which edges are as narrow as anywhere, in their order."""
    limit_px = min(tried.values()) + FLAT_PX
    return sorted(focus for focus, width_px in tried.items() if width_px <= limit_px)
