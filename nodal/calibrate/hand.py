"""What moves and watches the robot during calibration: a bench on the bus, asked as an operator asks it."""

import dataclasses
import sys
import time
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from messaging import topics
from messaging.control import Action, ActionRequest, ControllerState, Reply, TendonCommand, TendonState
from messaging.errors import UnansweredError
from messaging.session import Session
from messaging.shape import ShapeEstimate
from nodal.asking import answer
from nodal.errors import CalibrationError

Array = NDArray[np.float64]

TURN_S = 0.02
ANSWER_S = 2.0
SILENT_S = 1.0
DRIVE_SOUGHT_S = 5.0
"""The controller looks for its servos every second."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Glimpse:
    """What is known of the bench at one moment, on the clock of `now_s`."""

    now_s: float
    state: str
    reason: str
    advice: str
    fault: str
    """Its code; empty without one."""
    absence: str
    """Why the servos are not heard; empty while they are."""
    command_mm: Array
    """(A,); NaN while the tendons are told nothing."""
    position_mm: Array
    """(A,) as the servos report."""
    current_ma: Array
    """(A,)."""
    shape: ShapeEstimate | None
    """One that has come since the last glimpse."""
    captured_s: float
    """When its frames were taken."""


class Hand(Protocol):
    """Asks and watches."""

    def ask(self, action: Action, axis: str = "", distance_mm: float = 0.0) -> Reply:
        """The controller's answer."""
        ...

    def watch(self) -> Glimpse:
        """After a little while; raises CalibrationError when the controller is silent."""
        ...


def jog(hand: Hand, axis: int, tendons: int, distance_mm: float) -> Reply:
    """Ask for one axis to be jogged: a tendon or pair by its place, or the stage, which comes behind the `tendons`."""
    return hand.ask(Action.JOG, "stage" if axis == tendons else str(axis + 1), distance_mm)


def stop(hand: Hand) -> None:
    """Have the tendons let go at once; whatever led here is not hidden when nobody answers."""
    try:
        hand.ask(Action.STOP)
        print("the tendons are let go", file=sys.stderr)
    except (UnansweredError, CalibrationError) as error:
        print(f"warning: the tendons may still be held: {error}", file=sys.stderr)


class BenchHand:
    """The hand on a bench that runs."""

    def __init__(self, session: Session) -> None:
        """It gives the operator's heartbeat for as long as it watches."""
        self._session = session
        self._states = session.newest(topics.CONTROLLER_STATE)
        self._commands = session.newest(topics.TENDON_COMMAND)
        self._tendons = session.newest(topics.TENDON_STATE)
        self._shapes = session.newest(topics.SHAPE)
        self._heartbeat = session.gives(topics.HEARTBEAT)
        self._state: ControllerState | None = None
        self._command: TendonCommand | None = None
        self._drive: TendonState | None = None
        self._heard_s = time.monotonic()

    def ask(self, action: Action, axis: str = "", distance_mm: float = 0.0) -> Reply:
        """See `Hand`; raises UnansweredError."""
        request = ActionRequest(action=action, axis=axis, distance_mm=distance_mm)
        reply = answer(self._session, topics.CONTROLLER_DO, request, ANSWER_S)
        self._states.take()
        self._state = None  # only what is said from now on shows what came of it
        return reply

    def watch(self) -> Glimpse:
        """See `Hand`."""
        time.sleep(TURN_S)
        self._heartbeat.give()
        begun_s = time.monotonic()
        while True:
            if (taken := self._states.take()) is not None:
                self._state, self._heard_s = cast("ControllerState", taken[0]), time.monotonic()
            if (taken := self._commands.take()) is not None:
                self._command = cast("TendonCommand", taken[0])
            if (taken := self._tendons.take()) is not None:
                self._drive = cast("TendonState", taken[0])
            if time.monotonic() - self._heard_s > SILENT_S:
                raise CalibrationError(f"the controller has been silent for {SILENT_S:g} s")
            if self._state is not None and self._drive is not None:
                break
            if self._state is not None and time.monotonic() - begun_s > DRIVE_SOUGHT_S:
                raise CalibrationError(f"the servos are not heard: {self._state.drive_absence}")
            time.sleep(TURN_S)
        shape = self._shapes.take()
        return self._glimpse(
            self._state, self._drive, None if shape is None else cast("ShapeEstimate", shape[0])
        )

    def _glimpse(self, state: ControllerState, drive: TendonState, shape: ShapeEstimate | None) -> Glimpse:
        position_mm, now_s = drive.position_mm, time.monotonic()
        told = self._command if state.commanded else None
        command_mm = np.full(len(position_mm), np.nan)
        if told is not None:
            command_mm = np.append(told.displacement_mm, told.insertion_mm)[: len(position_mm)]
        return Glimpse(
            now_s=now_s,
            state=state.state.value,
            reason=state.reason,
            advice=state.advice,
            fault=state.fault,
            absence=state.drive_absence,
            command_mm=command_mm,
            position_mm=position_mm,
            current_ma=drive.current_ma,
            shape=shape,
            captured_s=0.0 if shape is None else now_s - shape.capture_to_publish_ns / 1e9,
        )
