"""The seam for control laws: what a law is given, what it answers. controller/laws holds one file for each law.

A law is pure: everything that it remembers is the state that it returns and is given back, so a replay repeats it.
"""

import dataclasses
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from drivers.actuators import ActuatorState

Array = NDArray[np.float64]
S = TypeVar("S")

SAME_ARC_MM = 1.0
"""How far a nodal point may wander along the robot, by measuring, and still be the same point."""


def same_points(arc_mm: Array, others_mm: Array) -> bool:
    """True when nodal points at these arc lengths are the same, one by one."""
    return arc_mm.shape == others_mm.shape and bool((np.abs(arc_mm - others_mm) < SAME_ARC_MM).all())


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Measurement:
    """A shape that arrived in this cycle, with all its nodal points, k of them, in the robot frame.

    `capture_s` is when its frames were taken, on the loop's clock; `led` (m,) are the rows of the points that are led.
    """

    capture_s: float
    arc_mm: Array
    """(k,)."""
    node_mm: Array
    """(k, 3)."""
    covariance_mm2: Array
    """(k, 3, 3)."""
    led: NDArray[np.intp]

    @property
    def led_mm(self) -> Array:
        """(m, 3) where the points that are led were seen."""
        return self.node_mm[self.led]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Desired:
    """Where nodal points (m, 3) should be, and how fast they should move, at one moment."""

    node_mm: Array
    velocity_mm_s: Array


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Points:
    """Which nodal points a law leads: arc lengths (m,), weights (m,), and the axes (A,) that it may move."""

    arc_mm: Array
    weights: Array
    movable: NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Beginning(Generic[S]):
    """What a law begins with. `command_mm` (A,) is what the actuators were last told; `before` is what the law remembers of
    what it did last, on this robot since it was homed: other points perhaps, or the same.

    `lost_motion_mm` (A,) is what play and friction swallow where an axis turns round, as homing found it; NaN where it did
    not look.
    """

    points: Points
    command_mm: Array
    measured: Measurement
    now_s: float
    lost_motion_mm: Array
    before: S | None


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class LawInputs:
    """What a law sees in one cycle. `command_mm` (A,) is what the actuators were last told, after all limits; `drive` what
    they reported in this cycle, if they did.
    """

    now_s: float
    dt_s: float
    command_mm: Array
    drive: ActuatorState | None
    desired: Desired
    measured: Measurement | None


class Law(Protocol, Generic[S]):
    """A control law with memory S."""

    lead_s: float
    """How far ahead of now `desired` should be, so that the robot arrives in time."""

    def start(self, beginning: Beginning[S]) -> S:
        """The memory of a law that begins with these points."""
        ...

    def step(self, state: S, inputs: LawInputs) -> tuple[S, Array]:
        """The memory after this cycle, and the command (A,) that should be sent."""
        ...
