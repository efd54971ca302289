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


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Measurement:
    """A shape that arrived in this cycle: nodal points (m, 3) in the robot frame at `capture_s` on the loop's clock."""

    capture_s: float
    node_mm: Array


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Desired:
    """Where nodal points (m, 3) should be, and how fast they should move, at one moment."""

    node_mm: Array
    velocity_mm_s: Array


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Points:
    """Which nodal points a law looks after: arc lengths (m,), weights (m,), and the axes (A,) that it may move."""

    arc_mm: Array
    weights: Array
    movable: NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Beginning:
    """What a law begins with. `command_mm` (A,) is what the actuators were last told.

    `lost_motion_mm` (A,) is what play and friction swallow where an axis turns round, as homing found it; NaN where it did
    not look.
    """

    points: Points
    command_mm: Array
    measured: Measurement
    now_s: float
    lost_motion_mm: Array


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

    def start(self, beginning: Beginning) -> S:
        """The memory of a law that begins with these points and knows nothing of what was before."""
        ...

    def step(self, state: S, inputs: LawInputs) -> tuple[S, Array]:
        """The memory after this cycle, and the command (A,) that should be sent."""
        ...
