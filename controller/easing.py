"""Setting off and coming to a stand without jerks: a speed that eases in and out, and a clock that can be stopped. Pure.

Speeds change over `EASING_S` as the smooth step 3 u^2 - 2 u^3, so what moves at v mm/s is accelerated by 1.5 v / EASING_S
at most, and the acceleration itself begins and ends at zero.
"""

import dataclasses
from typing import Self

EASING_S = 0.3


def eased(u: float) -> float:
    """From 0 at u <= 0 to 1 at u >= 1."""
    u = min(max(u, 0.0), 1.0)
    return u * u * (3 - 2 * u)


def eased_area(u: float) -> float:
    """The integral of `eased` from 0 to u: 1/2 at u = 1, and u - 1/2 from there."""
    within = min(max(u, 0.0), 1.0)
    return within**3 * (1 - within / 2) + max(u - 1.0, 0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stretch:
    """A stretch of `length_s` that is run through from a stand to a stand, at a rate of 1 in between; it may be endless."""

    length_s: float

    @property
    def peak(self) -> float:
        """The highest rate; below 1 when the stretch ends before it is reached."""
        return min(1.0, self.length_s / EASING_S)

    @property
    def duration_s(self) -> float:
        """How long that takes."""
        return max(self.length_s, EASING_S) + EASING_S if self.length_s else 0.0

    def at(self, elapsed_s: float) -> tuple[float, float]:
        """How far it has come after this time, and at what rate it goes on."""
        left_s = self.duration_s - elapsed_s
        if left_s <= 0:
            return self.length_s, 0.0
        if left_s < EASING_S:
            u = left_s / EASING_S
            return self.length_s - self.peak * EASING_S * eased_area(u), self.peak * eased(u)
        u = elapsed_s / EASING_S
        return self.peak * EASING_S * eased_area(u), self.peak * eased(u)


@dataclasses.dataclass(frozen=True, kw_only=True)
class OwnTime:
    """A clock that reads `own_s` at `now_s` and runs at `rate` then, easing from there to `aim`: 1 to run, 0 to stand."""

    now_s: float
    own_s: float = 0.0
    rate: float = 1.0
    aim: float = 1.0

    @property
    def _easing_s(self) -> float:
        return EASING_S * abs(self.aim - self.rate)

    def at(self, now_s: float) -> float:
        """What it reads; before its beginning it is taken to have run at the rate that it began with."""
        elapsed_s, easing_s = now_s - self.now_s, self._easing_s
        within_s = min(elapsed_s, easing_s)
        own_s = self.own_s + self.rate * within_s + self.aim * max(elapsed_s - easing_s, 0.0)
        if easing_s:
            own_s += (self.aim - self.rate) * easing_s * eased_area(within_s / easing_s)
        return own_s

    def rate_at(self, now_s: float) -> float:
        """How fast it runs."""
        easing_s = self._easing_s
        if not easing_s:
            return self.rate
        return self.rate + (self.aim - self.rate) * eased((now_s - self.now_s) / easing_s)

    def aimed(self, aim: float, now_s: float) -> Self:
        """The same clock, told at `now_s` to run or to stand."""
        return dataclasses.replace(self, now_s=now_s, own_s=self.at(now_s), rate=self.rate_at(now_s), aim=aim)
