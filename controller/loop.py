"""One cycle of the controller: data in, data out, handed its time. Everything that decides is here or below.

A cycle looks (shape, drive), judges (faults, requests), and then moves as its mode demands.
"""

import dataclasses
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from controller import task as tasks
from controller.errors import CommandNotFiniteError, LawFailedError, TargetError
from controller.laws import make_law
from controller.limits import Limits
from controller.reference import Reference, check_target
from controller.settings import ControllerSettings
from controller.supervisor import Event, Happening, Mode, Supervision, next_state
from controller.task import Seen, Task
from controller.watch import Trouble, distrust, drive_faults, motion_faults
from drivers.actuators import ActuatorState
from messaging.control import Action, ActionRequest, Reply, Target
from messaging.settings import RobotSettings
from messaging.shape import ShapeEstimate

Array = NDArray[np.float64]
Request = ActionRequest | Target


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
    requests: tuple[Request, ...] = ()


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Outputs:
    """What the drive is to do, in the order of the fields, and what is to be said."""

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


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class LoopState:
    """What a cycle leaves to the next one."""

    supervision: Supervision
    command_mm: Array
    trouble: Trouble
    seen: Seen | None = None
    distrusted: str = "none has come"
    target: Target | None = None
    joined_s: float = 0.0
    """Where on the target's path to go on."""
    task: Task | None = None
    straight_since_s: float = np.inf

    @property
    def mode(self) -> Mode:
        """What the controller is doing."""
        return self.supervision.mode


class Loop:
    """The controller of one robot."""

    def __init__(self, settings: ControllerSettings, robot: RobotSettings) -> None:
        """Raises ControllerSetupError when the settings do not fit the robot or name no law."""
        self._settings = settings
        self._kinematics = settings.kinematics(robot)
        self._limits = Limits(settings.limits, self._kinematics.pairs)
        self._law = make_law(settings, self._kinematics)
        self._pairs_only = np.append(np.ones(self._kinematics.pairs, dtype=bool), False)
        self._untroubled = Trouble.none(self._kinematics.axes)
        self._all_axes = np.ones(self._kinematics.axes, dtype=bool)

    def start(self) -> LoopState:
        """In idle, knowing nothing."""
        return LoopState(
            supervision=Supervision(),
            command_mm=np.zeros(self._kinematics.axes),
            trouble=self._untroubled,
        )

    def step(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Outputs]:
        """The state after this cycle and what is to be done."""
        before = state
        state, fresh = self._look(state, inputs)
        state, replies, accepted = self._judge(state, inputs)
        state = self._prepare(state, before.mode, inputs.now_s, inputs.drive, retargeted=accepted is not None)
        try:
            state, cut_short = self._move(state, before.mode, fresh, inputs)
        except CommandNotFiniteError as error:
            failed = Supervision(mode=Mode.FAULT, reason=str(LawFailedError(error)), since_s=inputs.now_s)
            state, cut_short = dataclasses.replace(state, supervision=failed, task=None), ""
        engage = state.mode.torque and not before.mode.torque
        homed = state.mode is Mode.READY and before.mode is Mode.HOMING
        powered = before.mode.torque or (inputs.drive is not None and inputs.drive.torque)
        return state, Outputs(
            release=powered and not state.mode.torque,
            engage=engage,
            zero_mm=state.command_mm if homed or engage else None,
            command_mm=state.command_mm if state.mode.torque else None,
            replies=replies,
            accepted=accepted,
            reason=cut_short or self._reason(state, inputs),
        )

    def _look(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Seen | None]:
        """Take in a new shape, if it may be acted on."""
        if inputs.sighting is None:
            return state, None
        shape, age_s = inputs.sighting.shape, inputs.sighting.age_s
        capture_s = inputs.now_s - age_s
        last_s = -np.inf if state.seen is None else state.seen.capture_s
        why_not = distrust(shape, age_s, capture_s, last_s, self._settings.sensing.maximum_age_s)
        if not why_not and state.task is not None:
            why_not = tasks.misfit(state.task, shape)
        if why_not:
            return dataclasses.replace(state, distrusted=why_not), None
        seen = Seen(shape=shape, capture_s=capture_s, arrived_s=inputs.now_s)
        return dataclasses.replace(state, seen=seen, distrusted="none has come since"), seen

    def _judge(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, tuple[Reply, ...], Target | None]:
        """Faults first, then what was noticed, then what was asked."""
        unseen_s = inputs.now_s - state.seen.arrived_s if state.seen is not None else np.inf
        blind = unseen_s > self._settings.sensing.timeout_s
        faults = motion_faults(state.supervision, unseen_s, state.distrusted, self._settings, inputs.now_s)
        trouble = self._untroubled
        if state.mode.torque:
            trouble, drive = drive_faults(
                inputs.drive,
                inputs.absence,
                state.trouble,
                settings=self._settings,
                limits=self._limits,
                now_s=inputs.now_s,
            )
            faults = [*drive, *faults]
        refusals = [self._refusal(request, state, inputs, blind=blind) for request in inputs.requests]
        noticed = self._noticed(state, inputs.now_s, blind=blind)
        asked = [
            Happening(event=Event(request.action.value), reason=f"the operator asked to {request.action}")
            for request, refusal in zip(inputs.requests, refusals, strict=True)
            if _is_order(request) and not refusal
        ]
        supervision, allowed = next_state(state.supervision, [*noticed, *asked], faults, inputs.now_s)
        outcome = iter(allowed[len(noticed) :])
        for index, request in enumerate(inputs.requests):
            if _is_order(request) and not refusals[index] and not next(outcome):
                refusals[index] = f"{request.action} is not possible in {state.mode}: {supervision.reason}"
        targets = [
            request
            for request, refusal in zip(inputs.requests, refusals, strict=True)
            if isinstance(request, Target) and not refusal
        ]
        state = dataclasses.replace(state, supervision=supervision, trouble=trouble)
        if targets:
            state = dataclasses.replace(state, target=targets[-1], joined_s=0.0)
        replies = tuple(
            Reply(
                accepted=not refusal,
                state=supervision.mode.state.value,
                reason=refusal
                or (
                    f"target {request.name} accepted"
                    if isinstance(request, Target)
                    else self._reason(state, inputs)
                ),
            )
            for request, refusal in zip(inputs.requests, refusals, strict=True)
        )
        return state, replies, targets[-1] if targets else None

    def _refusal(self, request: Request, state: LoopState, inputs: Inputs, *, blind: bool) -> str:
        """Why what was asked cannot be done whatever the mode; nothing when it can."""
        seen = state.seen
        if isinstance(request, Target):
            arcs = (
                {} if seen is None else dict(zip(seen.shape.node_names, seen.shape.node_arc_mm, strict=True))
            )
            try:
                check_target(request, arcs, self._kinematics, self._limits, self._settings)
            except TargetError as error:
                return str(error)
            return ""
        if request.action is Action.HOME and inputs.drive is None:
            return f"no tendon drive: {inputs.absence}"
        if request.action in (Action.HOME, Action.ARM) and (seen is None or blind):
            return f"no trusted shape: {state.distrusted}"
        if request.action is Action.ARM and seen is not None and state.target is not None:
            return tasks.missing_nodes(state.target.node_names, seen.shape)
        return ""

    def _noticed(self, state: LoopState, now_s: float, *, blind: bool) -> list[Happening]:
        if state.mode is Mode.TRACKING and blind:
            return [Happening(event=Event.SENSING_LOST, reason=f"no trusted shape: {state.distrusted}")]
        if state.mode is Mode.WAITING and not blind:
            return [Happening(event=Event.SENSING_GOOD, reason="shapes are trusted again")]
        if state.mode is Mode.HOMING and now_s - state.straight_since_s > self._settings.homing.settle_s:
            return [Happening(event=Event.HOMED, reason="homed")]
        if state.mode is Mode.RELAXING and not state.command_mm[:-1].any():
            return [Happening(event=Event.RELAXED, reason="relaxed")]
        return []

    def _prepare(
        self, state: LoopState, before: Mode, now_s: float, drive: ActuatorState | None, *, retargeted: bool
    ) -> LoopState:
        """Set up what the mode needs when it was entered just now, or when its target changed."""
        entered = state.mode is not before
        if entered and before is Mode.TRACKING and state.task is not None and not retargeted:
            state = dataclasses.replace(state, joined_s=state.task.reference.path_s(now_s))
        if state.mode is Mode.HOMING and entered:
            if not before.torque and drive is not None:
                state = dataclasses.replace(state, command_mm=self._taken_up(drive.insertion_mm))
            return dataclasses.replace(state, task=self._homing(state, now_s), straight_since_s=np.inf)
        if state.mode is Mode.READY and entered:
            return dataclasses.replace(state, command_mm=self._taken_up(state.command_mm[-1]), task=None)
        if state.mode is Mode.TRACKING and (entered or retargeted):
            return dataclasses.replace(state, task=self._tracking(state, now_s))
        if entered and state.mode is not Mode.WAITING:
            return dataclasses.replace(state, task=None)
        return state

    def _taken_up(self, insertion_mm: float) -> Array:
        """The command that calls the present displacements zero."""
        insertion_mm = min(max(insertion_mm, self._limits.low_mm[-1]), self._limits.high_mm[-1])
        return np.append(np.zeros(self._kinematics.pairs), insertion_mm)

    def _homing(self, state: LoopState, now_s: float) -> Task | None:
        if state.seen is None:
            return None
        target = tasks.straight_target(state.seen.shape)
        reference = Reference.towards(
            target, state.seen.shape.node_mm, now_s, self._settings.homing.node_speed_mm_s
        )
        return tasks.begin(
            self._law, reference, state.seen, self._pairs_only, command_mm=state.command_mm, now_s=now_s
        )

    def _tracking(self, state: LoopState, now_s: float) -> Task | None:
        if state.seen is None or state.target is None:
            return None
        reference = Reference.towards(
            state.target,
            tasks.starting_points(state.target, state.seen, state.task, now_s),
            now_s,
            self._settings.maximum_node_speed_mm_s,
            state.joined_s,
        )
        return tasks.begin(
            self._law, reference, state.seen, self._all_axes, command_mm=state.command_mm, now_s=now_s
        )

    def _move(
        self, state: LoopState, before: Mode, fresh: Seen | None, inputs: Inputs
    ) -> tuple[LoopState, str]:
        """The next command, and in words how it was cut short; raises CommandNotFiniteError."""
        wanted, task = state.command_mm, state.task
        if state.mode is Mode.RELAXING:
            most = self._settings.relax_mm_s * inputs.dt_s
            wanted = np.append(wanted[:-1] - np.clip(wanted[:-1], -most, most), wanted[-1])
        elif state.mode in (Mode.HOMING, Mode.TRACKING) and state.mode is before and task is not None:
            task, wanted = tasks.advance(
                self._law, task, fresh, command_mm=wanted, now_s=inputs.now_s, dt_s=inputs.dt_s
            )
            if state.mode is Mode.HOMING and fresh is not None:
                straight = task.settled(self._settings.homing.within_mm, inputs.now_s)
                since_s = min(state.straight_since_s, inputs.now_s) if straight else np.inf
                state = dataclasses.replace(state, straight_since_s=since_s)
        if not state.mode.torque:
            return state, ""
        limited = self._limits.apply(wanted, state.command_mm, inputs.dt_s)
        trouble = state.trouble.pushing("; ".join(limited.at_travel), inputs.now_s)
        state = dataclasses.replace(state, command_mm=limited.command_mm, task=task, trouble=trouble)
        return state, "; ".join((*limited.at_travel, *limited.at_rate))

    def _reason(self, state: LoopState, inputs: Inputs) -> str:
        """Why the mode is what it is; an absent drive is no fault in idle, but it is worth saying."""
        if state.mode is Mode.IDLE and inputs.drive is None:
            return inputs.absence
        return state.supervision.reason


def _is_order(request: Request) -> TypeGuard[ActionRequest]:
    return isinstance(request, ActionRequest) and request.action is not Action.STATUS
