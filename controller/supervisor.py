"""What the controller is doing, and what may follow from it.

The rule: torque is on only in a mode that an operator's `home` or `jog` led to, through modes in which nothing has failed
since. So `stop` and every fault end in a mode without torque, from anywhere, in the cycle in which they come; a restart
begins in idle and arms nothing; and nothing but the operator's `home` or `relax` leads out of a fault. `Homed` needs no
flag: ready, tracking, hold, waiting and relaxing can be reached through homing only, and unhomed, where a jog from idle
leads and homing whose operator is lost, goes on to homing or back to idle.

Stop lets the tendons go at once: slack tendons cannot hurt the robot, the backbone straightens by itself, and the stage's
screw keeps its place without torque. Relax leads the tendons back to zero slowly before it lets go, where zero is known.
"""

import dataclasses
from collections.abc import Sequence
from enum import StrEnum
from typing import Any, Self

from controller.errors import FaultError
from controller.faults import FAULTS
from messaging.control import State


class Mode(StrEnum):
    """What the controller is doing: the states of `messaging.control.State`, with the reasons of a hold told apart."""

    IDLE = "idle"
    HOMING = "homing"
    READY = "ready"
    TRACKING = "tracking"
    HOLD = "hold"
    """Tendons keep their place, unless the operator jogs one of them."""
    WAITING = "waiting"
    """A hold until shapes are trusted again."""
    RELAXING = "relaxing"
    """A hold in which the tendons are let go slowly."""
    UNHOMED = "unhomed"
    """A hold before homing, for jogging."""
    FAULT = "fault"

    @property
    def state(self) -> State:
        """What others are told."""
        return State.HOLD if self in (Mode.WAITING, Mode.RELAXING) else State(self.value)

    @property
    def torque(self) -> bool:
        """True when servos hold the tendons."""
        return self not in (Mode.IDLE, Mode.FAULT)


class Event(StrEnum):
    """What can happen, beside faults: the operator's actions, and what the loop notices."""

    HOME = "home"
    ARM = "arm"
    HOLD = "hold"
    PAUSE = "pause"
    RESUME = "resume"
    ABORT = "abort"
    JOG = "jog"
    RELAX = "relax"
    STOP = "stop"
    HOMED = "homed"
    RELAXED = "relaxed"
    SENSING_LOST = "sensing lost"
    SENSING_GOOD = "sensing good"
    OPERATOR_LOST = "operator lost"


_ARMED = (Mode.READY, Mode.TRACKING, Mode.HOLD, Mode.WAITING, Mode.RELAXING)

TRANSITIONS: dict[tuple[Mode, Event], Mode] = {
    (Mode.IDLE, Event.HOME): Mode.HOMING,
    (Mode.IDLE, Event.JOG): Mode.UNHOMED,
    (Mode.IDLE, Event.RELAX): Mode.IDLE,
    (Mode.IDLE, Event.STOP): Mode.IDLE,
    (Mode.UNHOMED, Event.HOME): Mode.HOMING,
    (Mode.UNHOMED, Event.HOLD): Mode.UNHOMED,
    (Mode.UNHOMED, Event.JOG): Mode.UNHOMED,
    (Mode.UNHOMED, Event.RELAX): Mode.IDLE,
    (Mode.UNHOMED, Event.STOP): Mode.IDLE,
    (Mode.HOMING, Event.HOMED): Mode.READY,
    (Mode.HOMING, Event.OPERATOR_LOST): Mode.UNHOMED,
    (Mode.HOMING, Event.RELAX): Mode.IDLE,
    (Mode.HOMING, Event.STOP): Mode.IDLE,
    **{(mode, Event.ARM): Mode.TRACKING for mode in _ARMED},
    **{(mode, Event.HOLD): Mode.HOLD for mode in _ARMED},
    **{(mode, Event.RELAX): Mode.RELAXING for mode in _ARMED},
    **{(mode, Event.STOP): Mode.IDLE for mode in _ARMED},
    **{(mode, Event.HOME): Mode.HOMING for mode in _ARMED if mode is not Mode.TRACKING},
    (Mode.READY, Event.JOG): Mode.HOLD,
    (Mode.HOLD, Event.JOG): Mode.HOLD,
    (Mode.READY, Event.ABORT): Mode.READY,
    (Mode.HOLD, Event.ABORT): Mode.HOLD,
    (Mode.WAITING, Event.ABORT): Mode.HOLD,
    (Mode.TRACKING, Event.ABORT): Mode.HOLD,
    (Mode.TRACKING, Event.PAUSE): Mode.TRACKING,
    (Mode.TRACKING, Event.RESUME): Mode.TRACKING,
    (Mode.WAITING, Event.PAUSE): Mode.WAITING,
    (Mode.WAITING, Event.RESUME): Mode.WAITING,
    (Mode.TRACKING, Event.SENSING_LOST): Mode.WAITING,
    (Mode.WAITING, Event.SENSING_GOOD): Mode.TRACKING,
    (Mode.TRACKING, Event.OPERATOR_LOST): Mode.HOLD,
    (Mode.WAITING, Event.OPERATOR_LOST): Mode.HOLD,
    (Mode.HOLD, Event.OPERATOR_LOST): Mode.HOLD,
    (Mode.UNHOMED, Event.OPERATOR_LOST): Mode.UNHOMED,
    (Mode.RELAXING, Event.RELAXED): Mode.IDLE,
    (Mode.FAULT, Event.HOME): Mode.HOMING,
    (Mode.FAULT, Event.RELAX): Mode.IDLE,
    (Mode.FAULT, Event.STOP): Mode.FAULT,
}
"""Every pair that is not here changes nothing; an operator who asks for one is told so."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault in numbers; without a unit there are none."""

    code: str
    value: float = 0.0
    limit: float = 0.0
    unit: str = ""

    @property
    def advice(self) -> str:
        """What the operator can do."""
        return FAULTS[self.code].advice


@dataclasses.dataclass(frozen=True, kw_only=True)
class Supervision:
    """The mode, why, and since when on the loop's clock. `fault` is there in the mode of that name only."""

    mode: Mode = Mode.IDLE
    reason: str = "started"
    since_s: float = 0.0
    fault: Fault | None = None

    @classmethod
    def failed(cls, error: FaultError, now_s: float) -> Self:
        """In fault because of this."""
        fault = Fault(code=error.code, value=error.value, limit=error.limit, unit=error.unit)
        return cls(mode=Mode.FAULT, reason=str(error), since_s=now_s, fault=fault)

    @property
    def told(self) -> dict[str, Any]:
        """The fields of a `FaultMessage`."""
        if self.fault is None:
            return {}
        return {
            "fault": self.fault.code,
            "fault_value": self.fault.value,
            "fault_limit": self.fault.limit,
            "fault_unit": self.fault.unit,
            "advice": self.fault.advice,
        }


@dataclasses.dataclass(frozen=True, kw_only=True)
class Happening:
    """An event, and in words what led to it."""

    event: Event
    reason: str


def next_state(
    current: Supervision, happenings: Sequence[Happening], faults: Sequence[FaultError], now_s: float
) -> tuple[Supervision, tuple[bool, ...]]:
    """What follows in this cycle, and for each happening whether it was allowed.

    Faults come first and only where there is torque to lose; the first one is kept. A fault and a stop make everything
    that happened beside them void. An operator who is lost is the reason from then on, in a hold too.
    """
    only_stop = any(happening.event is Event.STOP for happening in happenings)
    if faults and current.mode.torque:
        current, only_stop = Supervision.failed(faults[0], now_s), True
    allowed = []
    for happening in happenings:
        following = TRANSITIONS.get((current.mode, happening.event))
        allowed.append(following is not None and (not only_stop or happening.event is Event.STOP))
        told = following is not current.mode or happening.event is Event.OPERATOR_LOST
        if allowed[-1] and told and following is not None:
            current = Supervision(mode=following, reason=happening.reason, since_s=now_s)
    return current, tuple(allowed)
