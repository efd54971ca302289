"""The last place that a command passes: what is not finite is refused, what goes too far or too fast is cut short and said.

Pure. A command is (displacement_mm of every tendon or pair; insertion_mm of the stage, if there is one), A values.
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


def axis_name(axis: int, tendons: int) -> str:
    """What a person calls this axis: one of the tendons (or pairs), or the stage behind them."""
    return "stage" if axis == tendons else f"tendon {axis + 1}"


class Limits:
    """Travel and rate of every axis."""

    def __init__(self, settings: LimitSettings, tendons: int, *, stage: bool = True) -> None:
        """So many tendons or pairs, and the stage if there is one."""
        reach, (stage_low, stage_high) = settings.displacement_mm, settings.insertion_mm
        self.tendons = tendons
        self.current_ma = settings.current_ma
        self.least_tension_ma = settings.least_tension_ma
        self.tightening_mm_s = settings.tightening_mm_s
        self.low_mm = np.array([-reach] * tendons + [stage_low] * stage)
        self.high_mm = np.array([reach] * tendons + [stage_high] * stage)
        self.rate_mm_s = np.array([settings.displacement_mm_s] * tendons + [settings.insertion_mm_s] * stage)

    @property
    def stage_mm(self) -> tuple[float, float]:
        """Where the base may be along +Z: both 0 without a stage."""
        if self.tendons == len(self.low_mm):
            return 0.0, 0.0
        return float(self.low_mm[-1]), float(self.high_mm[-1])

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
            f"{axis_name(axis, self.tendons)}: {value[axis]:.3f} {what} {low[axis]:g} to {high[axis]:g}"
            for axis in np.flatnonzero(which).tolist()
        )
