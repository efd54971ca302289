"""Timing laws: how a motion from a stand to a stand spends its time. Pure."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEFAULT_RAMP = 0.25
"""Share of a trapezoid's duration in which it gains speed, and in which it loses it again."""


class Timing(StrEnum):
    """Names of the laws."""

    MINIMUM_JERK = "minimum-jerk"
    """The smoothest: 10 u^3 - 15 u^4 + 6 u^5 (Flash, Hogan 1985)."""
    TRAPEZOID = "trapezoid"
    """Constant acceleration, constant speed, the same acceleration back."""

    def peak(self, ramp: float = DEFAULT_RAMP) -> float:
        """Highest over mean speed."""
        return 1.875 if self is Timing.MINIMUM_JERK else 1 / (1 - ramp)

    def share(self, u: Array, ramp: float = DEFAULT_RAMP) -> Array:
        """Which share of the way lies behind after these shares of the time; a ramp of a trapezoid takes `ramp` of it."""
        if self is Timing.MINIMUM_JERK:
            return u**3 * (10 - 15 * u + 6 * u**2)
        rising, falling = np.minimum(u, ramp), np.maximum(u - (1 - ramp), 0.0)
        cruised = np.clip(u - ramp, 0.0, 1 - 2 * ramp)
        share: Array = (rising**2 / (2 * ramp) + cruised + falling - falling**2 / (2 * ramp)) / (1 - ramp)
        return share
