"""What the controller is doing, and what may follow from it.

The rule: torque is on only in a mode that an operator's `home` led to, through modes in which nothing has failed since.
So `stop` and every fault end in a mode without torque, from anywhere, in the cycle in which they come; `homed` needs no
flag, since ready, tracking and hold can be reached through homing only; a restart begins in idle and arms nothing; and
nothing but the operator's `home` or `relax` leads out of a fault.

Stop lets the tendons go at once: slack tendons cannot hurt the robot, the backbone straightens by itself, and the stage's
screw keeps its place without torque. Relax leads the tendons back to zero slowly before it lets go.
"""

import dataclasses
from collections.abc import Sequence
from enum import StrEnum

from controller.errors import FaultError
from messaging.control import State


class Mode(StrEnum):
    """What the controller is doing: the states of `messaging.control.State`, with the reasons of a hold told apart."""

    IDLE = "idle"
    HOMING = "homing"
    READY = "ready"
    TRACKING = "tracking"
    HOLD = "hold"
    WAITING = "waiting"
    """A hold until shapes are trusted again."""
    RELAXING = "relaxing"
    """A hold in which the tendons are let go slowly."""
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
    RELAX = "relax"
    STOP = "stop"
    HOMED = "homed"
    RELAXED = "relaxed"
    SENSING_LOST = "sensing lost"
    SENSING_GOOD = "sensing good"


_ARMED = (Mode.READY, Mode.TRACKING, Mode.HOLD, Mode.WAITING, Mode.RELAXING)

TRANSITIONS: dict[tuple[Mode, Event], Mode] = {
    (Mode.IDLE, Event.HOME): Mode.HOMING,
    (Mode.IDLE, Event.RELAX): Mode.IDLE,
    (Mode.IDLE, Event.STOP): Mode.IDLE,
    (Mode.HOMING, Event.HOMED): Mode.READY,
    (Mode.HOMING, Event.RELAX): Mode.IDLE,
    (Mode.HOMING, Event.STOP): Mode.IDLE,
    **{(mode, Event.ARM): Mode.TRACKING for mode in _ARMED},
    **{(mode, Event.HOLD): Mode.HOLD for mode in _ARMED},
    **{(mode, Event.RELAX): Mode.RELAXING for mode in _ARMED},
    **{(mode, Event.STOP): Mode.IDLE for mode in _ARMED},
    **{(mode, Event.HOME): Mode.HOMING for mode in _ARMED if mode is not Mode.TRACKING},
    (Mode.TRACKING, Event.SENSING_LOST): Mode.WAITING,
    (Mode.WAITING, Event.SENSING_GOOD): Mode.TRACKING,
    (Mode.RELAXING, Event.RELAXED): Mode.IDLE,
    (Mode.FAULT, Event.HOME): Mode.HOMING,
    (Mode.FAULT, Event.RELAX): Mode.IDLE,
    (Mode.FAULT, Event.STOP): Mode.FAULT,
}
"""Every pair that is not here changes nothing; an operator who asks for one is told so."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Supervision:
    """The mode, why, and since when on the loop's clock."""

    mode: Mode = Mode.IDLE
    reason: str = "started"
    since_s: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Happening:
    """An event, and in words what led to it."""

    event: Event
    reason: str


def next_state(
    current: Supervision, happenings: Sequence[Happening], faults: Sequence[FaultError], now_s: float
) -> tuple[Supervision, tuple[bool, ...]]:
    """What follows in this cycle, and for each happening whether it was allowed.

    Faults come first and only where there is torque to lose; the first one is kept. A stop makes everything that
    happened beside it void.
    """
    if faults and current.mode.torque:
        current = Supervision(mode=Mode.FAULT, reason=str(faults[0]), since_s=now_s)
    stop = any(happening.event is Event.STOP for happening in happenings)
    allowed = []
    for happening in happenings:
        following = TRANSITIONS.get((current.mode, happening.event))
        allowed.append(following is not None and (not stop or happening.event is Event.STOP))
        if allowed[-1] and following not in (None, current.mode):
            current = Supervision(mode=following, reason=happening.reason, since_s=now_s)
    return current, tuple(allowed)
