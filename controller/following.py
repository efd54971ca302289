"""How servos follow their commands: a lag that passes, and a sag that stays under load and friction. Pure."""

import dataclasses
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SAG_S = 0.2
"""Within which time it is seen by how much servos stay behind their goals."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Following:
    """Where servos would be that only lag behind their commands, and by how much they stay behind besides; (A,) each."""

    lagging_mm: Array
    sag_mm: Array

    @classmethod
    def at_rest(cls, command_mm: Array) -> Self:
        """Servos that are where they were sent."""
        return cls(lagging_mm=command_mm, sag_mm=np.zeros(len(command_mm)))

    def resting(self, command_mm: Array) -> Self:
        """The same servos when they have come to where they are sent, as far as they do."""
        return dataclasses.replace(self, lagging_mm=command_mm)

    def then(self, command_mm: Array, position_mm: Array, dt_s: float, lag_s: float) -> Self:
        """After `dt_s` more under this command, with servos that report `position_mm` and lag behind by `lag_s`."""
        lagging_mm = nearer(self.lagging_mm, command_mm, dt_s / lag_s)
        sag_mm = nearer(self.sag_mm, lagging_mm - position_mm, dt_s / _SAG_S)
        return dataclasses.replace(self, lagging_mm=lagging_mm, sag_mm=sag_mm)


def nearer(value: Array, goal: Array, share: float) -> Array:
    """`value` moved towards `goal` by this share of the way, all of it at most."""
    return value + min(share, 1.0) * (goal - value)
