"""Which configurations bring nodal points to places: damped Gauss-Newton, for many moments of a path at once. Pure.

A few moments are solved from the straight robot, the others start between their solutions: a path stays on one branch, and
costs little. Where the body comes too near to a region, it is pushed out of it as far as the nodal points leave it free.
"""

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray

from controller.planning.space import Space, interpolated

Array = NDArray[np.float64]

_COARSE, _COARSER = 9, 8
"""Of a path so many moments are solved first, or every so-manieth."""
_START_BEND_RAD = 0.8
_STEPS = 40
_DAMPING_MM = 0.3
_STAGE_DAMPING_MM = 1e-3
_STEP_MM = 1.5
"""How far a coordinate moves in one step: the model is not straight for longer."""
_PATIENCE, _HOPE = 4, 0.9
"""After so many steps the distance must have shrunk to this share for more of them to be worth their time."""
_MISS_COUNTS = 100.0
_TRIED = 3
"""How many moments of a path are tried from other starts."""
_AT_END_MM = 1e-6
_HELD = 1e3
"""How much heavier than a nodal point an axis weighs that stands at its end."""
_SPREADS = 4
_PUSHES = 8
_PUSHED_CLEAR_MM = 0.2
"""How much farther out than it must a body is pushed, so that it ends up outside."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Wanted:
    """Places (k, n, 3) of nodal points at these arc lengths (n,), and how much each of them counts (n,)."""

    place_mm: Array
    arc_mm: Array
    weights: Array

    def at(self, moments: NDArray[np.intp] | slice) -> "Wanted":
        """The same at some of the moments."""
        return dataclasses.replace(self, place_mm=self.place_mm[moments])

    @property
    def root(self) -> Array:
        """(n, 1) square roots of the weights, the highest 1."""
        root: Array = np.sqrt(self.weights / self.weights.max())[:, None]
        return root


def start_of(space: Space, wanted: Wanted) -> Array:
    """(k, C) straight robots to start from, as high as they may stand: bending only lowers a robot."""
    starts = np.zeros((len(wanted.place_mm), space.coordinates))
    if space.kinematics.stage:
        starts[:, -1] = (wanted.place_mm[..., 2] - wanted.arc_mm).max(axis=1)
    return space.within(starts)


def bent_starts(space: Space, wanted: Wanted) -> Array:
    """(b, k, C) other robots to start from: straight ones cannot shorten themselves, and a bend the other way may fit better.

    Sections bend towards the places and across, all of them alike or in turns.
    """
    straight, aside = start_of(space, wanted), wanted.place_mm[:, -1, :2]
    towards = np.where(np.linalg.norm(aside, axis=-1, keepdims=True) > 1e-3, aside, [1.0, 0.0])
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    across = towards[:, ::-1] * [-1.0, 1.0]
    sections = len(space.kinematics.length_mm)
    turns = (-1.0) ** np.arange(sections)
    starts = []
    for direction, signs in itertools.product((towards, across), (np.ones(sections), turns, -turns)):
        bent = straight.copy()
        bend = _START_BEND_RAD * signs[:, None] * direction[:, None, :]
        bent[:, : 2 * sections] = space.bent(bend.reshape(len(straight), -1))
        starts.append(space.within(bent))
    return np.stack(starts)


def solve_path(space: Space, wanted: Wanted, *, near_enough_mm: float, start: Array | None = None) -> Array:
    """(k, C) configurations along a path, from `start` (C,), or from whichever start leads nearest and clear of regions."""
    moments = len(wanted.place_mm)
    some = spread(moments, max(_COARSE, moments // _COARSER))
    coarse = wanted.at(some)
    first = start_of(space, coarse) if start is None else np.tile(start, (len(some), 1))
    solved = solve(space, coarse, first, near_enough_mm=near_enough_mm)
    short = shortfall(space, coarse, solved, near_enough_mm)
    if short.any():
        solved = _from_other_starts(space, coarse, solved, short, near_enough_mm)
        short = shortfall(space, coarse, solved, near_enough_mm)
    if len(some) == moments:
        return solved
    each = np.arange(moments)
    solved = solve(space, wanted, interpolated(each, some, solved), near_enough_mm=near_enough_mm)
    for _ in range(0 if short.any() else _SPREADS):
        bad = shortfall(space, wanted, solved, near_enough_mm) > 0
        if not bad.any() or bad.all():
            break
        # between two branches: go on from the neighbours
        good = np.flatnonzero(~bad)
        edge = np.flatnonzero(bad & (np.roll(~bad, 1) | np.roll(~bad, -1)))
        neighbour = good[np.abs(edge[:, None] - good).argmin(axis=1)]
        solved[edge] = solve(space, wanted.at(edge), solved[neighbour], near_enough_mm=near_enough_mm)
    return solved


def spread(moments: int, count: int) -> NDArray[np.intp]:
    """So many of the moments, or all, spread evenly."""
    return np.unique(np.linspace(0, moments - 1, count).round().astype(np.intp))


def _from_other_starts(
    space: Space, wanted: Wanted, known: Array, short: Array, near_enough_mm: float
) -> Array:
    """The same, all from the start that serves the worst moments best, if that is better than what is known."""
    worst = np.argsort(short)[-_TRIED:]
    starts = bent_starts(space, wanted)
    tried = wanted.at(np.tile(worst, len(starts)))
    there = _to_places(
        space, tried, starts[:, worst].reshape(-1, space.coordinates), near_enough_mm=near_enough_mm
    )
    failing = shortfall(space, tried, there, near_enough_mm).reshape(len(starts), -1).max(axis=1)
    if failing.min() >= short.max():
        return known
    return solve(space, wanted, starts[failing.argmin()], near_enough_mm=near_enough_mm)


def shortfall(space: Space, wanted: Wanted, configurations: Array, near_enough_mm: float) -> Array:
    """(k,) how bad they are, 0 where all is well: by how much the body comes too near to regions, and, counting far more,
    by how much nodal points miss their places.
    """
    missed = missed_mm(space, wanted, configurations).max(axis=-1) - near_enough_mm
    bad: Array = np.maximum(np.maximum(_MISS_COUNTS * missed, -space.spare_mm(configurations)), 0.0)
    return bad


def missed_mm(space: Space, wanted: Wanted, configurations: Array) -> Array:
    """(k, n) how far these configurations leave nodal points from their places."""
    nodes, _ = space.nodes_and_jacobian(configurations, wanted.arc_mm)
    missed: Array = np.linalg.norm(wanted.place_mm - nodes, axis=-1)
    return missed


def solve(space: Space, wanted: Wanted, start: Array, *, near_enough_mm: float) -> Array:
    """(k, C) configurations near `start` (k, C) that bring nodal points as near as they get, clear of regions if they can."""
    solved = _to_places(space, wanted, start, near_enough_mm=near_enough_mm)
    return _clear(space, wanted, solved, near_enough_mm)


def _clear(space: Space, wanted: Wanted, solved: Array, near_enough_mm: float) -> Array:
    """These configurations, pushed out of regions where nodal points still come near enough then."""
    close = np.flatnonzero(space.spare_mm(solved) < 0)
    close = close[missed_mm(space, wanted.at(close), solved[close]).max(axis=-1) <= 2 * near_enough_mm]
    if not len(close):
        return solved
    pushed = _out_of_regions(space, wanted.at(close), solved[close])
    well = shortfall(space, wanted.at(close), pushed, 2 * near_enough_mm) == 0
    cleared = solved.copy()
    cleared[close[well]] = pushed[well]
    return cleared


def _out_of_regions(space: Space, wanted: Wanted, start: Array) -> Array:
    solved, going = start.copy(), np.arange(len(start))
    for _ in range(_PUSHES):
        solved[going] = _pushed(space, wanted.at(going), solved[going])
        going = going[space.spare_mm(solved[going]) < 0]
        if not len(going):
            break
    return solved


def _to_places(space: Space, wanted: Wanted, start: Array, *, near_enough_mm: float) -> Array:
    solved, going = start.copy(), np.arange(len(start))
    before_mm = np.full(len(start), np.inf)
    for step in range(_STEPS):
        here = solved[going]
        nodes, jacobian = space.nodes_and_jacobian(here, wanted.arc_mm)
        missing = wanted.place_mm[going] - nodes
        missed = np.linalg.norm(missing, axis=-1).max(axis=-1)
        far = missed > near_enough_mm
        going, missed = going[far], missed[far]
        if not len(going):
            break
        rows, wished = wanted.root[..., None] * jacobian[far], wanted.root * missing[far]
        solved[going] = _stepped(space, here[far], _rows(rows), _values(wished))
        if step % _PATIENCE == _PATIENCE - 1:
            hopeful = missed < _HOPE * before_mm[going]
            before_mm[going] = missed
            going = going[hopeful]
    return solved


def _pushed(space: Space, wanted: Wanted, here: Array) -> Array:
    """One step out of regions, nodal points staying where they should be as far as they can."""
    nodes, jacobian = space.nodes_and_jacobian(here, wanted.arc_mm)
    distance, outward = space.plant.regions.clearance(space.body_mm(here))
    lacking = np.maximum(space.plant.clearance_mm + _PUSHED_CLEAR_MM - distance, 0.0)
    touched = lacking.any(axis=(0, 2))
    lacking, outward = lacking[:, touched], outward[:, touched]
    _, body_jacobian = space.nodes_and_jacobian(here, space.plant.body_arc_mm[touched])
    away = np.where(lacking[..., None] > 0, outward, 0.0) @ body_jacobian
    missing = wanted.root * (wanted.place_mm - nodes)
    return _stepped(
        space,
        here,
        np.concatenate([_rows(wanted.root[..., None] * jacobian), _rows(away)], axis=1),
        np.concatenate([_values(missing), _values(lacking)], axis=1),
    )


def _stepped(space: Space, here: Array, rows: Array, wished: Array) -> Array:
    """(k, C) one step by damped least squares of rows (k, r, C) for (k, r, 1), within all travels.

    Where an axis would be pushed beyond its end it is held there, and the others are asked again.
    """
    limits, commands = space.plant.limits, space.commands(here)
    across = rows.swapaxes(-1, -2)
    normal, pull = across @ rows + np.diag(space.weigh(_DAMPING_MM, _STAGE_DAMPING_MM) ** 2), across @ wished
    step = np.linalg.solve(normal, pull)[..., 0]
    push = step @ space.command_of.T
    blocked = ((commands >= limits.high_mm - _AT_END_MM) & (push > 0)) | (
        (commands <= limits.low_mm + _AT_END_MM) & (push < 0)
    )
    if blocked.any():
        held = space.command_of * (_HELD * blocked)[..., None]
        step = np.linalg.solve(normal + held.swapaxes(-1, -2) @ held, pull)[..., 0]
    most = space.weigh(_STEP_MM, np.inf)
    return space.within(here + np.clip(step, -most, most))


def _rows(derivatives: Array) -> Array:
    """(k, r, C) of derivatives (k, ..., C)."""
    return derivatives.reshape(len(derivatives), -1, derivatives.shape[-1])


def _values(values: Array) -> Array:
    """(k, r, 1) of values (k, ...)."""
    return values.reshape(len(values), -1, 1)
