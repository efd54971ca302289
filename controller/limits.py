"""The last place that a command passes: what is not finite is refused, what goes too far or too fast is cut short and said.

Pure. A command is (displacement_mm of every pair; insertion_mm), A values.
"""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller.errors import CommandNotFiniteError
from controller.settings import LimitSettings

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Limited:
    """A command that may be sent, and in words where it was cut short."""

    command_mm: Array
    at_travel: tuple[str, ...]
    at_rate: tuple[str, ...]


def axis_name(axis: int, axes: int) -> str:
    """What a person calls this axis."""
    return "stage" if axis == axes - 1 else f"pair {axis + 1}"


class Limits:
    """Travel and rate of every axis."""

    def __init__(self, settings: LimitSettings, pairs: int) -> None:
        """`pairs` tendon pairs and the stage."""
        reach, (stage_low, stage_high) = settings.displacement_mm, settings.insertion_mm
        self.low_mm = np.append(np.full(pairs, -reach), stage_low)
        self.high_mm = np.append(np.full(pairs, reach), stage_high)
        self.rate_mm_s = np.append(np.full(pairs, settings.displacement_mm_s), settings.insertion_mm_s)

    def apply(self, command_mm: Array, previous_mm: Array, dt_s: float) -> Limited:
        """`command_mm` (A,) as it may follow `previous_mm` (A,) after `dt_s`; raises CommandNotFiniteError."""
        if command_mm.shape != self.low_mm.shape or not np.isfinite(command_mm).all():
            raise CommandNotFiniteError(
                f"command {command_mm.tolist()} mm refused: it must be {len(self.low_mm)} finite numbers"
            )
        within = np.minimum(np.maximum(command_mm, self.low_mm), self.high_mm)
        most = self.rate_mm_s * dt_s
        step = within - previous_mm
        slow = np.minimum(np.maximum(step, -most), most)
        # where nothing was cut the command passes unchanged, to the last bit
        sent = np.where(slow == step, within, previous_mm + slow)
        if (sent == command_mm).all():
            return Limited(command_mm=sent, at_travel=(), at_rate=())
        return Limited(
            command_mm=sent,
            at_travel=self._say(
                within != command_mm, command_mm, "mm asked, travel", self.low_mm, self.high_mm
            ),
            at_rate=self._say(slow != step, step / dt_s, "mm/s asked, rate", -self.rate_mm_s, self.rate_mm_s),
        )

    def beyond_travel(self, position_mm: Array, tolerance_mm: float) -> tuple[str, ...]:
        """The axes that stand at `position_mm` (A,) beyond their travel, in words."""
        beyond = (position_mm < self.low_mm - tolerance_mm) | (position_mm > self.high_mm + tolerance_mm)
        return self._say(beyond, position_mm, "mm, travel", self.low_mm, self.high_mm) if beyond.any() else ()

    def _say(
        self, which: NDArray[np.bool_], value: Array, what: str, low: Array, high: Array
    ) -> tuple[str, ...]:
        return tuple(
            f"{axis_name(axis, len(value))}: {value[axis]:.3f} {what} {low[axis]:g} to {high[axis]:g}"
            for axis in np.flatnonzero(which).tolist()
        )
