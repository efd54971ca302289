"""What goes into one cycle of the controller, what comes out, and what it leaves to the next one."""

import dataclasses
import math
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from controller.probing import Search
from controller.supervisor import Mode, Supervision
from controller.task import Seen, Task
from controller.watch import Trouble
from drivers.actuators import ActuatorState
from messaging.control import Action, ActionRequest, Reply, Target
from messaging.errors import CodecError
from messaging.shape import ShapeEstimate
from messaging.snapshot import freeze, thaw

Array = NDArray[np.float64]
Request = ActionRequest | Target

PACKAGES = ("controller", "messaging")
"""Where the classes in a snapshot of the state may come from."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """A shape that arrived since the last cycle, and how long ago its frames were taken."""

    shape: ShapeEstimate
    age_s: float


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Inputs:
    """What one cycle sees. `now_s` is monotonic; `dt_s` the time since the last cycle as far as commands may use it."""

    now_s: float
    dt_s: float
    sighting: Sighting | None
    drive: ActuatorState | None
    absence: str
    """Why `drive` is missing."""
    absence_fault: str = ""
    """Code of the fault that its absence is while torque should be on."""
    requests: tuple[Request, ...] = ()
    heartbeat: bool = False
    """An operator's heartbeat was heard since the last cycle."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Outputs:
    """What the drive is to do, in the order of the fields, and what is to be said."""

    tendons: int
    """How many of the axes are tendons; the stage, if there is one, comes behind them."""
    release: bool
    """Let all tendons go."""
    engage: bool
    """Hold them where they are."""
    zero_mm: Array | None
    """(A,) what the present position is called from now on."""
    command_mm: Array | None
    """(A,) where to go."""
    replies: tuple[Reply, ...]
    accepted: Target | None
    """A new target."""
    reason: str
    """Why the mode is what it is, or how the command was cut short."""

    def split(self, axes_mm: Array) -> tuple[Array, float]:
        """Displacements (D,), and the insertion, which is 0 of a robot without a stage."""
        return axes_mm[: self.tendons], float(axes_mm[self.tendons :].sum())


@dataclasses.dataclass(frozen=True, kw_only=True)
class Jog:
    """One axis on its way to where the operator wants it, at `goal_mm`."""

    axis: int
    goal_mm: float
    words: str


Asked = Target | Action | Jog
"""What the operator asked, as far as the motion must know of it."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class LoopState:
    """What a cycle leaves to the next one."""

    supervision: Supervision
    command_mm: Array
    trouble: Trouble
    lost_motion_mm: Array
    """(A,) as the last homing found it; NaN where it did not look."""
    stepped_s: float = np.inf
    """When this cycle was; infinity before the first."""
    heartbeat_s: float = -np.inf
    """When an operator's heartbeat was heard last."""
    seen: Seen | None = None
    distrusted: str = "none has come"
    target: Target | None = None
    joined_s: float = 0.0
    """Where on the target's path to go on."""
    task: Task | None = None
    learnt: Any = None
    """What the law remembered when it led the robot last, since it was homed."""
    paused: bool = False
    progress: float = 0.0
    """Share of the target that was done when it was followed last."""
    search: Search | None = None
    """The first part of homing."""
    straightening_since_s: float = np.inf
    """Since when the second part leads the robot straight."""
    straight_since_s: float = np.inf
    jog: Jog | None = None

    def to_bytes(self) -> bytes:
        """The snapshot of this state; raises CodecError when a law remembers what a snapshot cannot keep."""
        return freeze(self)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The state in this snapshot; raises CodecError."""
        state = thaw(data, PACKAGES)
        if not isinstance(state, cls):
            raise CodecError(f"a snapshot holds a {type(state).__name__}, not the controller's memory")
        return state

    def aimed(self, target: Target | None) -> Self:
        """With this target, or with none, of which nothing was done yet."""
        return dataclasses.replace(self, target=target, joined_s=0.0, progress=0.0)

    @property
    def mode(self) -> Mode:
        """What the controller is doing."""
        return self.supervision.mode

    def unseen_s(self, now_s: float) -> float:
        """Time since a trusted shape arrived."""
        return math.inf if self.seen is None else now_s - self.seen.arrived_s

    def blind(self, now_s: float, timeout_s: float) -> bool:
        """True when no trusted shape arrived for longer than `timeout_s`."""
        return self.unseen_s(now_s) > timeout_s
