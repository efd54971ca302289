"""The whole body along a path: without coming too near to regions between its moments, if there is a way. Pure."""

import numpy as np
from numpy.typing import NDArray

from controller.planning.solving import Wanted, bent_starts, shortfall, solve, solve_path, spread, start_of
from controller.planning.space import Encroachment, Space, interpolated

Array = NDArray[np.float64]

_FOLLOWED = 12
"""In so many steps a path is followed."""


def lead_body(
    space: Space, wanted: Wanted, *, near_enough_mm: float, start: Array | None = None
) -> tuple[Array, Encroachment | None]:
    """`solve_path`, and where the body comes nearest to a region, between moments too.

    If that is too near, the path is followed step by step as well: then there are no jumps from one way of reaching places
    to another.
    """
    solved = solve_path(space, wanted, near_enough_mm=near_enough_mm, start=start)
    nearest = space.nearest_between(solved)
    if nearest is None or nearest.spare_mm >= 0:
        return solved, nearest
    first = wanted.at(slice(1))
    starts = (
        np.concatenate([start_of(space, first), *bent_starts(space, first)]) if start is None else start[None]
    )
    followed = _follow(space, wanted, starts, near_enough_mm)
    if shortfall(space, wanted, followed, near_enough_mm).any():
        return solved, nearest
    return followed, space.nearest_between(followed)


def _follow(space: Space, wanted: Wanted, starts: Array, near_enough_mm: float) -> Array:
    """(k, C) each from the one before, from whichever of the starts (b, C) leads nearest, clear and with least motion."""
    some = spread(len(wanted.place_mm), _FOLLOWED)
    here, led = starts, []
    for moment in some:
        here = solve(space, wanted.at(np.full(len(starts), moment)), here, near_enough_mm=near_enough_mm)
        led.append(here)
    ways = np.stack(led, axis=1)
    failing = [shortfall(space, wanted.at(some), way, near_enough_mm).max() for way in ways]
    swept = space.sweep_mm(np.diff(ways, axis=1)).sum(axis=-1)
    best = ways[np.lexsort((swept, failing))[0]]
    each = np.arange(len(wanted.place_mm))
    return solve(space, wanted, interpolated(each, some, best), near_enough_mm=near_enough_mm)
