"""A way between configurations that keeps clear of regions along the whole body: straight on, or around. Pure, seeded.

Two trees grow from both ends by random samples until they meet (Kuffner, LaValle, "RRT-Connect", 2000); the way is then
shortened wherever one can go straight, and rounded off. Distances between configurations are what the body sweeps, in mm.
"""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller.planning.space import Space, interpolated

Array = NDArray[np.float64]

_LOOK_MM = 1.0
"""How far the body sweeps between two configurations that are looked at."""
_EXTENSION_MM = 60.0
_SHORTCUTS = 80
_ROUNDINGS = 40
_ROUND_MM = 2.0
_MOST_POINTS = 400


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """Configurations (k, C) close to one another, from one end to the other, and how many samples it took to find them."""

    configurations: Array
    samples: int


class _Tree:
    """Configurations with whom they were reached from."""

    def __init__(self, roots: Array, metric: Array) -> None:
        self._metric = metric
        self.configurations = [*roots]
        self._scaled = [*(roots * metric)]
        self._parents = [-1] * len(roots)

    def nearest(self, configuration: Array) -> int:
        away = np.array(self._scaled) - configuration * self._metric
        return int((away * away).sum(axis=1).argmin())

    def add(self, configuration: Array, parent: int) -> int:
        self.configurations.append(configuration)
        self._scaled.append(configuration * self._metric)
        self._parents.append(parent)
        return len(self._parents) - 1

    def branch(self, index: int) -> list[Array]:
        """From the root to this one."""
        found = []
        while index >= 0:
            found.append(self.configurations[index])
            index = self._parents[index]
        return found[::-1]


class Search:
    """Ways through one space whose every configuration has at least `spare_mm` to spare."""

    def __init__(self, space: Space, spare_mm: float, seed: int) -> None:
        """The same seed finds the same way."""
        self._space, self._spare_mm = space, spare_mm
        self._random = np.random.default_rng(seed)
        self._metric = space.sweep_mm(np.eye(space.coordinates))

    def way(self, start: Array, goals: Array, most_samples: int) -> Way | None:
        """From `start` (C,) to one of the goals (g, C); None when none was found within so many samples."""
        nearest_first = np.argsort(np.linalg.norm((goals - start) * self._metric, axis=1))
        for goal in goals[nearest_first]:
            if self._straight(start, goal):
                return Way(configurations=self._dense([start, goal]), samples=0)
        corners, samples = self._grown(start, goals, most_samples)
        if corners is None:
            return None
        return Way(configurations=self._rounded(self._dense(self._shortened(corners))), samples=samples)

    def _grown(self, start: Array, goals: Array, most_samples: int) -> tuple[list[Array] | None, int]:
        ours, others = _Tree(start[None], self._metric), _Tree(goals, self._metric)
        from_start = True
        for sample in range(1, most_samples + 1):
            towards = self._space.random(self._random)
            parent = ours.nearest(towards)
            reached = self._advanced(ours.configurations[parent], towards, _EXTENSION_MM)
            if reached is not None:
                own = ours.add(reached, parent)
                other = others.nearest(reached)
                met = self._advanced(others.configurations[other], reached, np.inf)
                if met is not None:
                    other = others.add(met, other)
                    if np.array_equal(met, reached):
                        legs = ours.branch(own), others.branch(other)
                        first, second = legs if from_start else legs[::-1]
                        return [*first, *second[-2::-1]], sample
            ours, others, from_start = others, ours, not from_start
        return None, most_samples

    def _advanced(self, here: Array, towards: Array, most_mm: float) -> Array | None:
        """The farthest that one gets straight on; None when that is nowhere."""
        share = min(most_mm / max(float(self._space.sweep_mm(towards - here)), 1e-9), 1.0)
        there = towards if share == 1 else here + share * (towards - here)
        steps = self._between(here, there)
        free = self._free(steps[1:])
        if free.all():
            return there
        last = int(free.argmin())
        return steps[last] if last else None

    def _straight(self, here: Array, there: Array) -> bool:
        return bool(self._free(self._between(here, there)[1:]).all())

    def _free(self, configurations: Array) -> NDArray[np.bool_]:
        free: NDArray[np.bool_] = self._space.spare_mm(configurations) >= self._spare_mm
        return free

    def _between(self, here: Array, there: Array) -> Array:
        steps = max(int(np.ceil(float(self._space.sweep_mm(there - here)) / _LOOK_MM)), 1)
        between: Array = here + np.linspace(0, 1, steps + 1)[:, None] * (there - here)
        return between

    def _shortened(self, corners: list[Array]) -> list[Array]:
        """The same with every corner left out that one can pass by, tried between places picked at random."""
        for _ in range(_SHORTCUTS):
            if len(corners) < 3:
                break
            first, second = np.sort(self._random.uniform(0, len(corners) - 1, 2))
            before, after = int(first), int(second)
            if before == after:
                continue
            begin = corners[before] + (first - before) * (corners[before + 1] - corners[before])
            end = corners[after] + (second - after) * (corners[after + 1] - corners[after])
            if self._straight(begin, end):
                corners = [*corners[: before + 1], begin, end, *corners[after + 1 :]]
        return corners

    def _dense(self, corners: list[Array]) -> Array:
        """Evenly spaced along the way."""
        points = np.array(corners)
        swept = np.append(0.0, np.cumsum(self._space.sweep_mm(np.diff(points, axis=0))))
        keep = np.append(True, np.diff(swept) > 0)
        points, swept = points[keep], swept[keep]
        count = int(np.clip(np.ceil(swept[-1] / _ROUND_MM), 8, _MOST_POINTS)) + 1
        even = np.linspace(0, swept[-1], count)
        return interpolated(even, swept, points)

    def _rounded(self, way: Array) -> Array:
        """Every place drawn between its neighbours, again and again, unless that comes too near."""
        for _ in range(_ROUNDINGS):
            drawn = way.copy()
            drawn[1:-1] = (way[:-2] + 2 * way[1:-1] + way[2:]) / 4
            free = self._free(drawn)
            moved = np.where(free[:, None], drawn, way)
            # between places that were drawn and others the way must be clear too
            middles = (moved[1:] + moved[:-1]) / 2
            if not self._free(middles).all():
                break
            way = moved
        return way
