"""The robot moved one axis at a time before anything is known of where it stands: by the controller's jogs, under all its limits."""

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from controller.limits import axis_name
from controller.settings import JogSettings
from messaging.control import Action, State
from messaging.errors import UnansweredError
from nodal.calibrate.hand import Glimpse, Hand, jog, stop
from nodal.errors import CalibrationError, RobotStoppedError

NS_PER_S = 1e9
SETTLED_S = 0.6
"""Until a robot that was moved stands still: its backbone creeps after its tendons."""
PATIENCE_S = 5.0
THERE_MM = 0.02
LET_GO_S = 20.0
_LET_GO = (State.IDLE, State.FAULT)
_LED = (State.UNHOMED, State.READY, State.HOLD)


class Mover:
    """Jogs axes and waits until they are there."""

    def __init__(self, hand: Hand, settings: JogSettings, tendons: int, turned: Callable[[], None]) -> None:
        """`tendons` is the number of tendons or pairs; what comes behind them is the stage. `turned` is called on every turn
        of every wait but that for the tendons to be let go, and may raise.
        """
        self._hand, self._settings, self._tendons, self._turned = hand, settings, tendons, turned

    @property
    def stage_mm(self) -> float:
        """Where the stage stands by its servo; 0 for a robot without one."""
        position_mm = self._hand.watch().position_mm
        return float(position_mm[self._tendons]) if len(position_mm) > self._tendons else 0.0

    def jog(self, axis: int, distance_mm: float) -> None:
        """One axis by this distance, in as many jogs as are needed; raises RobotStoppedError when it does not get there."""
        jogs = max(math.ceil(abs(distance_mm) / self._settings.at_most_mm - 1e-9), 1)
        for _ in range(jogs):
            self._jog(axis, distance_mm / jogs)

    def settled_ns(self) -> int:
        """Wait until the robot stands still, and tell the moment from which on it does (monotonic)."""
        what = "waiting until the robot stands still"
        end_s = self._watched(what).now_s + SETTLED_S
        while self._watched(what).now_s < end_s:
            pass
        return int(end_s * NS_PER_S)

    def attend(self) -> None:
        """Look after the robot while something else is waited for; raises RobotStoppedError when it is not led any more."""
        self._watched("looking at the robot")

    def let_go(self) -> None:
        """Relax the tendons; stop where that is refused. Returns when they are let go, or says that nobody answers."""
        try:
            if self._hand.ask(Action.RELAX).accepted and self._let_go_in_time():
                print("the tendons are let go", file=sys.stderr)
                return
        except (UnansweredError, CalibrationError) as error:
            print(f"warning: {error}", file=sys.stderr)
        stop(self._hand)

    def _let_go_in_time(self) -> bool:
        glimpse = self._hand.watch()
        end_s = glimpse.now_s + LET_GO_S
        while glimpse.state not in _LET_GO and glimpse.now_s < end_s:
            glimpse = self._hand.watch()
        return glimpse.state in _LET_GO

    def _jog(self, axis: int, distance_mm: float) -> None:
        before = self._hand.watch()
        told_mm = before.command_mm[axis]
        if math.isnan(told_mm):
            told_mm = before.position_mm[axis] if axis == self._tendons else 0.0
        reply = jog(self._hand, axis, self._tendons, distance_mm)
        what = f"the jog of {axis_name(axis, self._tendons)} by {distance_mm:g} mm"
        if not reply.accepted:
            raise RobotStoppedError(f"{what} was refused: {reply.reason}", reply.advice)
        end_s = before.now_s + abs(distance_mm) / self._settings.mm_s + PATIENCE_S
        while True:
            glimpse = self._watched(what)
            if abs(glimpse.command_mm[axis] - told_mm - distance_mm) < THERE_MM:
                return
            if glimpse.now_s > end_s:
                raise RobotStoppedError(f"{what} did not end in time")

    def _watched(self, what: str) -> Glimpse:
        self._turned()
        glimpse = self._hand.watch()
        if glimpse.state not in _LED:
            raise RobotStoppedError(f"{what} ended in {glimpse.state}: {glimpse.reason}", glimpse.advice)
        return glimpse


@contextmanager
def moving_robot(
    hand: Hand, settings: JogSettings, tendons: int, turned: Callable[[], None]
) -> Iterator[Mover]:
    """A mover; however the block is left, the tendons are let go. Raises RobotStoppedError when the robot is not free to be led."""
    mover, found = Mover(hand, settings, tendons, turned), hand.watch()
    if found.state not in (State.IDLE, *_LED):
        raise RobotStoppedError(
            f"the robot is not led: its controller is in {found.state}: {found.reason}", found.advice
        )
    try:
        yield mover
    finally:
        mover.let_go()
