"""A short memory of where something was, for looking back to the moment when frames were taken."""

import dataclasses
from bisect import bisect_right
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KEPT_S = 1.0
"""A shape may be as old as this when it arrives."""


@dataclasses.dataclass(frozen=True, eq=False)
class History:
    """Values at increasing times, no longer back than `KEPT_S`."""

    times_s: tuple[float, ...]
    values: tuple[Array, ...]

    @classmethod
    def of(cls, time_s: float, value: Array) -> Self:
        """A history that begins now."""
        return cls((time_s,), (value,))

    def then(self, time_s: float, value: Array) -> Self:
        """This history, gone on."""
        oldest = bisect_right(self.times_s, time_s - KEPT_S)
        return type(self)((*self.times_s[oldest:], time_s), (*self.values[oldest:], value))

    def at(self, time_s: float) -> Array:
        """The value at this time, between those remembered; the first or last one outside of them."""
        after = bisect_right(self.times_s, time_s)
        if after == 0:
            return self.values[0]
        if after == len(self.times_s):
            return self.values[-1]
        before_s, after_s = self.times_s[after - 1 : after + 1]
        share = (time_s - before_s) / (after_s - before_s)
        return (1 - share) * self.values[after - 1] + share * self.values[after]
