"""How long a motion takes, and how it spends its time."""

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from controller.planning.timing import DEFAULT_RAMP, Timing
from nodal.errors import CommandError

Array = NDArray[np.float64]

MOMENTS = 120


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pace:
    """As it was asked for: by its duration or by its highest speed. With neither, `easy_mm_s` is a speed that does no harm."""

    duration_s: float | None = None
    speed_mm_s: float | None = None
    acceleration_mm_s2: float | None = None
    timing: Timing = Timing.MINIMUM_JERK
    easy_mm_s: float = 10.0

    def __post_init__(self) -> None:
        """Refuse what contradicts itself; raises CommandError."""
        given = {
            "duration": (self.duration_s, "s"),
            "speed": (self.speed_mm_s, "mm/s"),
            "acceleration": (self.acceleration_mm_s2, "mm/s²"),
        }
        for what, (value, unit) in given.items():
            if value is not None and not 0 < value < math.inf:
                raise CommandError(f"a {what} of {value:g} {unit} is impossible; it must be above 0")
        if self.duration_s is not None and self.speed_mm_s is not None:
            raise CommandError("a motion is given a duration or a speed, not both")
        if self.acceleration_mm_s2 is not None and self.timing is not Timing.TRAPEZOID:
            raise CommandError(f"an acceleration belongs to the timing trapezoid, not to {self.timing}")

    @property
    def fixed(self) -> bool:
        """True when the operator said how fast."""
        return self.duration_s is not None or self.speed_mm_s is not None

    def spent(self, length_mm: float) -> tuple[Array, Array]:
        """Moments (k,) in s from a stand to a stand, and which share of the way lies behind then (k,); raises CommandError.

        A way of no length takes no time: one moment.
        """
        if length_mm <= 0:
            return np.zeros(1), np.ones(1)
        duration_s, ramp = self._duration_and_ramp(length_mm)
        u = np.linspace(0, 1, MOMENTS + 1)
        return u * duration_s, self.timing.share(u, ramp)

    def evenly(self, length_mm: float) -> tuple[Array, Array]:
        """The same for a round that is run through again and again, with no stand in it; raises CommandError."""
        if self.acceleration_mm_s2 is not None:
            raise CommandError("a closed way is run through evenly; it has no acceleration")
        u = np.linspace(0, 1, MOMENTS + 1)
        return u * (self.duration_s or length_mm / (self.speed_mm_s or self.easy_mm_s)), u

    def _duration_and_ramp(self, length_mm: float) -> tuple[float, float]:
        speed_mm_s, acceleration = self.speed_mm_s or self.easy_mm_s, self.acceleration_mm_s2
        if acceleration is None:
            return self.duration_s or self.timing.peak() * length_mm / speed_mm_s, DEFAULT_RAMP
        if self.duration_s is None:
            ramp_s = min(speed_mm_s / acceleration, math.sqrt(length_mm / acceleration))
            duration_s = ramp_s + length_mm / (acceleration * ramp_s)
            return duration_s, ramp_s / duration_s
        # the shorter root of length = acceleration * ramp_s * (duration_s - ramp_s)
        left = self.duration_s**2 - 4 * length_mm / acceleration
        if left < 0:
            raise CommandError(
                f"{length_mm:.1f} mm in {self.duration_s:g} s need an acceleration of "
                f"{4 * length_mm / self.duration_s**2:.1f} mm/s² at least; {acceleration:g} was given"
            )
        return self.duration_s, (self.duration_s - math.sqrt(left)) / (2 * self.duration_s)
