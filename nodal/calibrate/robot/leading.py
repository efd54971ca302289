"""Leading the robot from pose to pose, one axis at a time, and looking at it where it stands."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from controller.faults import DriveLostError
from controller.limits import axis_name
from controller.settings import ControllerSettings
from controller.watch import distrust
from messaging.control import Action, Reply, State
from messaging.shape import ShapeEstimate
from nodal.calibrate.hand import Glimpse, Hand, jog, stop
from nodal.calibrate.robot.standing import Stand, still
from nodal.errors import JogRefusedError, RobotStoppedError, ServosSilentError

Array = NDArray[np.float64]
Result = TypeVar("Result")

SETTLED_S = 0.3
"""Until servos and robot have come to rest after a move."""
SHAPES = 6
"""So many shapes say where the robot stands."""
STILL_WITHIN_S = 10.0
HEARD_WITHIN_S = 5.0
"""Until servos that were silent are found again: the controller looks for them every second."""
SILENCES = 2
"""So often servos may be silent: a computer that is busy for a moment may do that, a bad cable does it again."""
PATIENCE_S = 5.0
BLIND_S = 0.5
"""Without a trusted shape for so long a move is interrupted, until there is one within `PATIENCE_S`."""
THERE_MM = 1e-6
_ATTEMPTS = 12
_STANDING = (State.HOLD, State.READY, State.UNHOMED)
_UNSEEN = "see what the cameras show; smaller moves (--share) keep the robot in their sight"


class Leader:
    """Leads one robot; raises RobotStoppedError as soon as anything is not as it should be."""

    def __init__(
        self,
        hand: Hand,
        settings: ControllerSettings,
        tendons: int,
        turned: Callable[[], None],
        say: Callable[[str], None],
    ) -> None:
        """`turned` is called on every turn of every wait, and may raise; `say` is told what a person has to know."""
        self._hand, self._settings, self._tendons, self._turned = hand, settings, tendons, turned
        self._say, self._silences = say, 0
        self._allowed: tuple[State, ...] = (State.IDLE,)
        self._trusted_s = -np.inf
        self._why_not = "no shape has come yet"
        self.node_names: tuple[str, ...] = ()
        """Of the nodal points that were seen last."""

    def home(self) -> None:
        """Until the robot is homed."""
        self._asked(Action.HOME)
        within_s = self._tendons * 15.0 + 2 * self._settings.homing.timeout_s
        self._until(
            lambda glimpse: glimpse.state == State.READY, "homing", within_s, while_in=(State.HOMING,)
        )

    def let_go(self) -> None:
        """Lead the tendons of a homed robot back slowly and let them go; those of one that is not, at once."""
        self._asked(Action.RELAX)
        within_s = self._settings.limits.displacement_mm / self._settings.relax_mm_s + PATIENCE_S
        self._until(lambda glimpse: glimpse.state == State.IDLE, "relaxing", within_s, while_in=(State.HOLD,))
        self._allowed = (State.IDLE,)

    def patiently(self, step: Callable[[], Result], anew: Callable[[], None]) -> Result:
        """What the step gives. When servos do not answer for a moment in it, they are waited for, and after `anew` the step is
        begun again: `SILENCES` times in all that this leader does.
        """
        ready = True
        while True:
            try:
                if not ready:
                    self._wait_for_servos()
                    self._allowed = (State.FAULT,)
                    self.stand()  # a robot that was let go swings, and is not homed unseen
                    anew()
                    ready = True
                return step()
            except ServosSilentError as silence:
                self._silences += 1
                if self._silences > SILENCES:
                    raise
                ready = False
                self._say(f"{silence}; trying it again ({self._silences} of at most {SILENCES} times)")

    def go(self, command_mm: Array) -> None:
        """To this command (A,), one axis after the other: those first that come nearer to their zero."""
        begin_mm = self.command_mm()
        away = np.abs(command_mm) - np.abs(begin_mm)
        for axis in np.argsort(away, kind="stable").tolist():
            if abs(command_mm[axis] - begin_mm[axis]) > THERE_MM:
                self.move(axis, float(command_mm[axis]))

    def move(self, axis: int, to_mm: float) -> None:
        """One axis to this command; a move that is interrupted because nothing is seen goes on when something is."""
        at_most_mm = self._settings.jog.at_most_mm
        for _ in range(_ATTEMPTS + int(abs(to_mm - self.command_mm()[axis]) / at_most_mm)):
            left_mm = to_mm - float(self.command_mm()[axis])
            if abs(left_mm) < THERE_MM:
                return
            self._jog(axis, min(max(left_mm, -at_most_mm), at_most_mm))
        raise RobotStoppedError(
            f"{self.name(axis)} could not be moved: shapes are lost again and again: {self._why_not}", _UNSEEN
        )

    def name(self, axis: int) -> str:
        """What a person calls an axis."""
        return axis_name(axis, self._tendons)

    def command_mm(self) -> Array:
        """(A,) what the tendons are told; zeros while they are let go."""
        return np.nan_to_num(self._watched().command_mm)

    def stand(self) -> Stand:
        """Where the robot stands when it has come to rest."""
        begin_s = self._watched().now_s
        shapes: list[ShapeEstimate] = []
        glimpses: list[Glimpse] = []

        def seen(glimpse: Glimpse) -> bool:
            if (
                glimpse.shape is None
                or glimpse.captured_s < begin_s + SETTLED_S
                or self._distrust(glimpse.shape)
            ):
                return False
            shapes.append(glimpse.shape)
            glimpses.append(glimpse)
            self._same_nodes(glimpse.shape)
            return len(shapes) >= SHAPES and still(shapes[-SHAPES:])

        for _ in range(_ATTEMPTS):
            self._until(seen, "waiting until the robot stands still", STILL_WITHIN_S)
            if len(shapes) >= SHAPES:
                break
        else:
            raise RobotStoppedError(f"shapes are lost again and again: {self._why_not}", _UNSEEN)
        return Stand.of(shapes[-SHAPES:], glimpses[-SHAPES:])

    def stage_mm(self) -> float:
        """Where the stage stands, by its servo."""
        return float(self._watched().position_mm[self._tendons])

    def _same_nodes(self, shape: ShapeEstimate) -> None:
        if self.node_names not in ((), shape.node_names):
            raise RobotStoppedError("the nodal points were changed while the robot was looked at")
        self.node_names = shape.node_names

    def _jog(self, axis: int, distance_mm: float) -> None:
        before_mm = self.command_mm()
        goal_mm = before_mm[axis] + distance_mm
        self._answered(Action.JOG, jog(self._hand, axis, self._tendons, distance_mm))

        def there(glimpse: Glimpse) -> bool:
            return bool(abs(glimpse.command_mm[axis] - goal_mm) < THERE_MM)

        within_s = abs(distance_mm) / self._settings.jog.mm_s + PATIENCE_S
        self._until(there, f"the jog of {self.name(axis)} by {distance_mm:.2f} mm", within_s)

    def _asked(self, action: Action) -> None:
        self._answered(action, self._hand.ask(action))

    def _answered(self, action: Action, reply: Reply) -> None:
        if not reply.accepted:
            stands = action is Action.JOG and reply.state in _STANDING
            refused = JogRefusedError if stands else _stopped_by(reply.fault)
            raise refused(f"{action} was refused: {reply.reason}", reply.advice)
        self._allowed = _STANDING

    def _until(
        self,
        met: Callable[[Glimpse], bool],
        what: str,
        within_s: float,
        while_in: tuple[State, ...] = (),
    ) -> None:
        """Until that is so; or until shapes were not trusted for a moment and are again, with all axes held."""
        end_s = np.inf
        while True:
            glimpse = self._watched()
            end_s = min(end_s, glimpse.now_s + within_s)
            if met(glimpse):
                return
            if glimpse.state not in (while_in or self._allowed):
                words = f"{what} ended in {glimpse.state}: {glimpse.reason}"
                raise _stopped_by(glimpse.fault)(words, glimpse.advice)
            if self._allowed is _STANDING and not while_in and glimpse.now_s - self._trusted_s > BLIND_S:
                self._wait_for_sight(what)
                return
            if glimpse.now_s > end_s:
                raise RobotStoppedError(f"{what} took longer than {within_s:.0f} s")

    def _wait_for_sight(self, what: str) -> None:
        """Hold all axes until a shape is trusted again."""
        self._asked(Action.HOLD)
        glimpse = self._watched()
        end_s = glimpse.now_s + PATIENCE_S
        while glimpse.now_s - self._trusted_s > BLIND_S:
            if glimpse.now_s > end_s:
                raise RobotStoppedError(f"{what}: no trusted shape: {self._why_not}", _UNSEEN)
            glimpse = self._watched()

    def _wait_for_servos(self) -> None:
        glimpse = self._watched()
        end_s = glimpse.now_s + HEARD_WITHIN_S
        while glimpse.absence:
            if glimpse.now_s > end_s:
                raise RobotStoppedError(f"the servos are silent: {glimpse.absence}", glimpse.advice)
            glimpse = self._watched()

    def _watched(self) -> Glimpse:
        self._turned()
        glimpse = self._hand.watch()
        if glimpse.shape is not None:
            self._why_not = self._distrust(glimpse.shape)
            self._trusted_s = self._trusted_s if self._why_not else glimpse.captured_s
        return glimpse

    def _distrust(self, shape: ShapeEstimate) -> str:
        age_s = shape.capture_to_publish_ns / 1e9
        return distrust(shape, age_s, np.inf, -np.inf, self._settings.sensing.maximum_age_s)


@contextmanager
def leading_robot(
    hand: Hand,
    settings: ControllerSettings,
    tendons: int,
    turned: Callable[[], None],
    say: Callable[[str], None],
) -> Iterator[Leader]:
    """A leader; when the block fails, the tendons are let go at once. Raises RobotStoppedError, and asks nothing of the
    controller, when somebody else leads the robot.
    """
    found = hand.watch()
    if found.state != State.IDLE:
        raise RobotStoppedError(
            f"the robot is not free to be led: its controller is in {found.state}: {found.reason}",
            found.advice or "`nodal do relax` lets its tendons go",
        )
    try:
        yield Leader(hand, settings, tendons, turned, say)
    except BaseException:
        stop(hand)
        raise


def _stopped_by(fault: str) -> type[RobotStoppedError]:
    return ServosSilentError if fault == DriveLostError.code else RobotStoppedError
