"""From a target to where nodal points should be now. Pure.

A reference joins its path softly: from where the nodal points are, along straight lines, with the speed of a minimum-jerk
motion (Flash, Hogan 1985) that never exceeds the bound, to the moment of the path at which it goes on; what moves already
slows down meanwhile. Along the path it sets off from a stand and, if the path does not repeat, comes to a stand at its end.
It can be paused anywhere, and goes on from there.
"""

import dataclasses
import math
from typing import Self

import numpy as np
from numpy.typing import NDArray

from controller.easing import EASING_S, OwnTime, Stretch, eased, eased_area
from controller.law import Desired
from controller.path import along
from messaging.control import Target

Array = NDArray[np.float64]

_MINIMUM_JERK_PEAK = 1.875
"""Highest over mean speed of a minimum-jerk motion."""
_SLOWED_BY_S = 4 * EASING_S
"""An approach this long gains speed more slowly than what moved before loses it, so both together keep to the bound."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """A target on its way: from `start_mm` (m, 3), moving by `start_mm_s`, joining the path's `joined_s` after `approach_s`."""

    target: Target
    start_mm: Array
    start_mm_s: Array
    approach_s: float
    joined_s: float
    own_time: OwnTime
    """Counts from the beginning, and stands while the reference is paused."""
    done: float = 0.0
    """Share of the target that lay behind already, 0 to 1."""

    @classmethod
    def towards(
        cls,
        target: Target,
        start_mm: Array,
        now_s: float,
        speed_mm_s: float,
        joined_s: float = 0.0,
        *,
        done: float = 0.0,
        start_mm_s: Array | None = None,
    ) -> Self:
        """Begin now from `start_mm` (m, 3), no weighted nodal point faster than `speed_mm_s` until the path is joined.

        `start_mm_s` (m, 3) is how nodal points move at the beginning, if they do; `done` the progress of a reference that
        this one goes on with.
        """
        if start_mm_s is None:
            start_mm_s = np.zeros_like(start_mm)
        driven = target.weights > 0
        way = along(target, joined_s).node_mm - start_mm - EASING_S / 2 * start_mm_s
        approach_s = float(_MINIMUM_JERK_PEAK * np.linalg.norm(way, axis=1)[driven].max() / speed_mm_s)
        if start_mm_s[driven].any():
            approach_s = max(approach_s, _SLOWED_BY_S)
        return cls(
            target=target,
            start_mm=start_mm,
            start_mm_s=start_mm_s,
            approach_s=approach_s,
            joined_s=joined_s,
            own_time=OwnTime(now_s=now_s),
            done=done,
        )

    def paused(self, now_s: float) -> Self:
        """The same, slowing down to a stand along its way from now on."""
        return dataclasses.replace(self, own_time=self.own_time.aimed(0.0, now_s))

    def resumed(self, now_s: float) -> Self:
        """The same, setting off again from where it stands."""
        return dataclasses.replace(self, own_time=self.own_time.aimed(1.0, now_s))

    def joined(self, now_s: float) -> bool:
        """True when the approach is over."""
        return self.own_time.at(now_s) >= self.approach_s

    def progress(self, now_s: float) -> float:
        """Which share of the approach and the path lies behind, 0 to 1; of a path that repeats, which share of its round.

        It begins with what was done already, and the rest counts by its time; so it never goes back.
        """
        whole_s = self.approach_s + self._stretch.duration_s
        if math.isfinite(whole_s):
            share = min(max(self.own_time.at(now_s), 0.0) / whole_s, 1.0) if whole_s else 1.0
            return 1.0 - (1.0 - self.done) * (1.0 - share)
        beyond_s = self.path_s(now_s) - self.target.repeat_from_s
        round_s = float(self.target.time_s[-1]) - self.target.repeat_from_s
        return beyond_s % round_s / round_s if beyond_s > 0 else 0.0

    def path_s(self, now_s: float) -> float:
        """The target's own time: it stands still until the path is joined."""
        return self.joined_s + self._stretch.at(max(self.own_time.at(now_s) - self.approach_s, 0.0))[0]

    def at(self, now_s: float) -> Desired:
        """Where nodal points should be and how fast they should move."""
        own_s = max(self.own_time.at(now_s), 0.0)
        pace = self.own_time.rate_at(now_s)
        path_s, rate = self._stretch.at(max(own_s - self.approach_s, 0.0))
        path = along(self.target, self.joined_s + path_s)
        if own_s >= self.approach_s:
            return dataclasses.replace(path, velocity_mm_s=pace * rate * path.velocity_mm_s)
        u = own_s / self.approach_s
        drift_s = own_s - EASING_S * eased_area(own_s / EASING_S)
        way = path.node_mm - self.start_mm - EASING_S / 2 * self.start_mm_s
        velocity = 30 * u**2 * (1 - u) ** 2 / self.approach_s * way
        slowing = (1 - eased(own_s / EASING_S)) * self.start_mm_s
        return Desired(
            node_mm=self.start_mm + drift_s * self.start_mm_s + u**3 * (10 - 15 * u + 6 * u**2) * way,
            velocity_mm_s=pace * (velocity + slowing),
        )

    @property
    def _stretch(self) -> Stretch:
        """What is left of the path where it is joined."""
        if self.target.repeat and len(self.target.time_s) > 1:
            return Stretch(length_s=math.inf)
        return Stretch(length_s=max(float(self.target.time_s[-1]) - self.joined_s, 0.0))
