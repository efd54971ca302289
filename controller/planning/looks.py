"""The moments of a path that are looked at: so many that nothing larger than is said can be missed between them. Pure.

Between two moments of a target no coordinate of its path turns, so no nodal point moves farther there than its three
coordinates differ, added up: that is the measure of length here.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from controller.errors import UnknownNodeError
from controller.path import along
from controller.planning.solving import Wanted
from messaging.control import Target

Array = NDArray[np.float64]

_FINER = 8
"""How many times nearer to one another than bodies nodal points alone are looked at: they cost little."""
_MOST = 2000
"""Bodies of one path, more or less."""
_LEAST_S = 1e-12
_SPLITS = 5
"""More are never needed, unless a path jumps in no time at all; then it is too fast."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Looks:
    """Moments (k,) of a path, and where its n nodal points are asked to be then. Only those that are driven count."""

    names: tuple[str, ...]
    time_s: Array
    wanted: Wanted
    velocity_mm_s: Array
    """(k, n, 3)."""
    body: NDArray[np.intp]
    """(b,) the moments for which the whole body is looked at: the first, the last, the fastest, and enough of the others."""
    apart_mm: float
    """Between two of these no nodal point moves farther."""
    length_mm: float

    @property
    def place_mm(self) -> Array:
        """(k, n, 3)."""
        return self.wanted.place_mm

    @property
    def speed_mm_s(self) -> Array:
        """(k, n); of a jump in next to no time too, and infinite where numbers are too large to tell."""
        speed: Array = np.linalg.norm(self.velocity_mm_s, axis=-1)
        gone_mm = np.linalg.norm(np.diff(self.place_mm, axis=0), axis=-1)
        speed[1:] = np.maximum(speed[1:], gone_mm / np.maximum(np.diff(self.time_s), _LEAST_S)[:, None])
        speed[~np.isfinite(speed)] = np.inf
        return speed

    def straight_to(self, place_mm: Array, apart_mm: float) -> "Looks":
        """The way from where this one begins straight to (n, 3), all nodal points at once, as if it took a second."""
        way_mm = place_mm - self.place_mm[0]
        length_mm = float(_steps_mm(np.stack([self.place_mm[0], place_mm])).sum())
        apart_mm = max(apart_mm, length_mm / _MOST)
        share = np.linspace(0, 1, int(np.ceil(length_mm * _FINER / apart_mm)) + 1)
        wanted = dataclasses.replace(self.wanted, place_mm=self.place_mm[0] + share[:, None, None] * way_mm)
        velocity_mm_s = np.broadcast_to(way_mm, wanted.place_mm.shape)
        return dataclasses.replace(
            self,
            time_s=share,
            wanted=wanted,
            velocity_mm_s=velocity_mm_s,
            body=_bodies(_steps_mm(wanted.place_mm), velocity_mm_s, apart_mm),
            apart_mm=apart_mm,
            length_mm=length_mm,
        )


def look_along(target: Target, node_arc_mm: Mapping[str, float], apart_mm: float) -> Looks:
    """A target's path, with bodies no farther apart than `apart_mm` unless it is too long; raises UnknownNodeError."""
    if unknown := [name for name in target.node_names if name not in node_arc_mm]:
        raise UnknownNodeError(
            f"target {target.name}: no nodal point {', '.join(unknown)}; sensing reports {', '.join(node_arc_mm) or 'none'}"
        )
    driven = np.flatnonzero(target.weights > 0)
    names = tuple(target.node_names[index] for index in driven)
    time_s = _own_moments(target)
    path = along(target, time_s)
    steps_mm = _steps_mm(path.node_mm[:, driven])
    length_mm = float(steps_mm.sum())
    apart_mm = max(apart_mm, length_mm / _MOST)
    for _ in range(_SPLITS):
        if not (steps_mm > apart_mm / _FINER).any():
            break
        time_s = _split(time_s, np.ceil(steps_mm * _FINER / apart_mm))
        path = along(target, time_s)
        steps_mm = _steps_mm(path.node_mm[:, driven])
    return Looks(
        names=names,
        time_s=time_s,
        wanted=Wanted(
            place_mm=path.node_mm[:, driven],
            arc_mm=np.array([node_arc_mm[name] for name in names]),
            weights=target.weights[driven],
        ),
        velocity_mm_s=path.velocity_mm_s[:, driven],
        body=_bodies(steps_mm, path.velocity_mm_s[:, driven], apart_mm),
        apart_mm=apart_mm,
        length_mm=length_mm,
    )


def _own_moments(target: Target) -> Array:
    """(k,) the moments of a target and those in the middle between them, where it may be fastest."""
    time_s = target.time_s
    if len(time_s) == 1:
        return time_s
    if target.repeat:
        # the first piece of what repeats is another one when it is reached from the end
        seam = int(np.searchsorted(time_s, target.repeat_from_s))
        time_s = np.append(time_s, time_s[-1] + time_s[seam + 1] - time_s[seam])
    moments = np.sort(np.concatenate([time_s, (time_s[1:] + time_s[:-1]) / 2]))
    # at its very end a path stands; just before, it does not
    moments[-1] = np.nextafter(moments[-1], 0)
    return moments


def _bodies(steps_mm: Array, velocity_mm_s: Array, apart_mm: float) -> NDArray[np.intp]:
    # the first look within each stretch: two of them are a stretch and a step apart at most
    behind_mm = np.append(0.0, np.cumsum(steps_mm))
    stretch = np.floor(behind_mm / (apart_mm * (1 - 1 / _FINER)))
    first = np.flatnonzero(np.diff(stretch, prepend=-1.0))
    fastest = np.square(velocity_mm_s).sum(axis=-1).max(axis=-1).argmax()
    return np.union1d(first, [fastest, len(behind_mm) - 1])


def _steps_mm(place_mm: Array) -> Array:
    """(k - 1,) how far the nodal point that moves farthest moves between places (k, n, 3)."""
    steps: Array = np.abs(np.diff(place_mm, axis=0)).sum(axis=-1).max(axis=-1)
    return steps


def _split(time_s: Array, parts: Array) -> Array:
    """Every step between moments (k,) in so many parts (k - 1,)."""
    count = np.maximum(parts, 1).astype(np.intp)
    first = np.cumsum(count) - count
    part = np.arange(count.sum()) - np.repeat(first, count)
    return np.append(
        np.repeat(time_s[:-1], count) + np.repeat(np.diff(time_s) / count, count) * part, time_s[-1]
    )
