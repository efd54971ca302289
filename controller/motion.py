"""How each mode moves: what is set up when a mode is entered, and the next command. Pure."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from controller import task as tasks
from controller.cycle import Asked, Inputs, Jog, LoopState
from controller.errors import CommandNotFiniteError
from controller.faults import LawFailedError
from controller.homing import SlackSearch
from controller.laws import make_homing_law, make_law
from controller.plant import Plant
from controller.reference import Reference
from controller.settings import ControllerSettings
from controller.supervisor import Mode
from controller.task import Seen, Task
from messaging.control import Action, Target

Array = NDArray[np.float64]

FORGETTING = (Action.ABORT, Action.RELAX)
"""Orders after which there is no target."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Moved:
    """A cycle's motion: the state with its command, whether the present place has a new name, how commands were cut short."""

    state: LoopState
    renamed: bool = False
    cut_short: str = ""


class Motion:
    """The tendons and the stage of one robot."""

    def __init__(self, settings: ControllerSettings, plant: Plant) -> None:
        """Raises ControllerSetupError when the settings name no law."""
        self._settings = settings
        self._kinematics = plant.kinematics
        self._limits = plant.limits
        self._law, self._homing_law = make_law(settings, plant), make_homing_law(settings, plant)
        self._search = SlackSearch(settings.homing, plant)
        self._all_axes = np.ones(self._kinematics.axes, dtype=bool)
        self._tendons_only = np.arange(self._kinematics.axes) < self._kinematics.tendons

    def prepare(self, state: LoopState, before: Mode, inputs: Inputs, asked: Sequence[Asked]) -> LoopState:
        """Set up what the mode needs when it was entered just now, when its target changed, or when the operator asked for it.

        Raises LawFailedError.
        """
        entered = state.mode is not before
        retargeted = any(isinstance(one, Target) or one in FORGETTING for one in asked)
        if entered or retargeted:
            state = _ended(state, before, inputs.now_s)
        for one in asked:
            state = self._asked(state, one, inputs.now_s)
        if entered:
            state = _left(state)
        if entered and not before.torque and state.mode.torque and inputs.drive is not None:
            state = dataclasses.replace(state, command_mm=self.taken_up(inputs.drive.insertion_mm))
        if state.mode is Mode.HOMING and entered:
            return self._homing(state, inputs)
        if state.mode is Mode.READY and entered:
            return dataclasses.replace(
                state, command_mm=self.taken_up(float(state.command_mm[-1])), task=None
            )
        if state.mode is Mode.TRACKING and (entered or retargeted):
            return dataclasses.replace(state, task=self._tracking(state, inputs.now_s, led=not entered))
        if (entered and state.mode is not Mode.WAITING) or (retargeted and state.mode is Mode.WAITING):
            return dataclasses.replace(state, task=None)
        return state

    def named_zero(self, insertion_mm: float) -> Array:
        """(A,) what a place is called whose displacements become zero; a stage that reads `insertion_mm` keeps its name."""
        return np.append(np.zeros(self._kinematics.tendons), insertion_mm)[: self._kinematics.axes]

    def taken_up(self, insertion_mm: float) -> Array:
        """The command that calls the present displacements zero; it keeps the stage, in its travel."""
        low_mm, high_mm = self._limits.stage_mm
        return self.named_zero(min(max(insertion_mm, low_mm), high_mm))

    def doing(self, state: LoopState) -> str:
        """What this mode does just now, where its reason does not say it."""
        if state.mode is Mode.HOMING:
            return "leading the robot straight" if state.search is None else self._search.words(state.search)
        if state.jog is not None:
            return state.jog.words
        return "paused by the operator" if state.paused and state.mode is Mode.TRACKING else ""

    def _asked(self, state: LoopState, asked: Asked, now_s: float) -> LoopState:
        """Every order ends a jog, and some say more."""
        if isinstance(asked, Target):
            return state.aimed(asked)
        if isinstance(asked, Jog):
            return dataclasses.replace(state, jog=asked)
        state, task = dataclasses.replace(state, jog=None), state.task
        if asked in FORGETTING:
            return dataclasses.replace(state.aimed(None), paused=False)
        match asked:
            case Action.PAUSE | Action.RESUME:
                paused = asked is Action.PAUSE
                if task is not None and paused is not state.paused:
                    reference = task.reference.paused(now_s) if paused else task.reference.resumed(now_s)
                    task = dataclasses.replace(task, reference=reference)
                return dataclasses.replace(state, task=task, paused=paused)
            case Action.HOME:
                return state.aimed(state.target)
        return state

    def _homing(self, state: LoopState, inputs: Inputs) -> LoopState:
        """Begin with the search for slack, or with leading the robot straight."""
        state = dataclasses.replace(
            state, task=None, learnt=None, straight_since_s=np.inf, straightening_since_s=np.inf
        )
        if self._settings.homing.find_slack and inputs.drive is not None:
            search = self._search.start(state.command_mm, inputs.drive, inputs.now_s)
            return dataclasses.replace(state, search=search)
        return self._straightening(state, inputs.now_s)

    def _straightening(self, state: LoopState, now_s: float) -> LoopState:
        if state.seen is None:
            return state
        target = tasks.straight_target(state.seen.shape)
        reference = Reference.towards(
            target, state.seen.shape.node_mm, now_s, self._settings.homing.node_speed_mm_s
        )
        task = tasks.begin(
            self._homing_law,
            reference,
            state.seen,
            self._tendons_only,
            before=None,
            command_mm=state.command_mm,
            lost_motion_mm=state.lost_motion_mm,
            now_s=now_s,
        )
        return dataclasses.replace(state, task=task, straightening_since_s=now_s)

    def _tracking(self, state: LoopState, now_s: float, *, led: bool) -> Task | None:
        """`led`: nodal points follow a target already, and go on from where they are led."""
        if state.seen is None or state.target is None:
            return None
        start = tasks.starting_points(state.target, state.seen, state.task if led else None, now_s)
        reference = Reference.towards(
            state.target,
            start.node_mm,
            now_s,
            self._settings.maximum_node_speed_mm_s,
            state.joined_s,
            done=state.progress,
            start_mm_s=start.velocity_mm_s,
        )
        if state.paused:
            reference = reference.paused(now_s)
        return tasks.begin(
            self._law,
            reference,
            state.seen,
            self._all_axes,
            before=state.learnt,
            command_mm=state.command_mm,
            lost_motion_mm=state.lost_motion_mm,
            now_s=now_s,
        )

    def move(self, state: LoopState, before: Mode, fresh: Seen | None, inputs: Inputs) -> Moved:
        """The next command; raises FaultError when the law or homing fails."""
        wanted, dt_s = state.command_mm, inputs.dt_s
        if not state.mode.torque:
            return Moved(state=state)
        if state.mode is Mode.RELAXING:
            most = self._settings.relax_mm_s * dt_s
            wanted = np.where(self._tendons_only, wanted - np.clip(wanted, -most, most), wanted)
        elif state.jog is not None:
            state, wanted = self._jog(state, state.jog, dt_s)
        elif state.mode is before and self._may_follow(state, inputs.now_s):
            if state.search is not None and inputs.drive is not None:
                search, wanted, done = self._search.step(
                    state.search, fresh, command_mm=wanted, drive=inputs.drive, now_s=inputs.now_s, dt_s=dt_s
                )
                state = dataclasses.replace(state, search=search)
                if done:
                    return self._found(state, search.lost_motion_mm, inputs)
            elif state.task is not None:
                state, wanted = self._follow(state, state.task, fresh, inputs)
        return self._limited(state, wanted, inputs)

    def _jog(self, state: LoopState, jog: Jog, dt_s: float) -> tuple[LoopState, Array]:
        wanted, most_mm = state.command_mm.copy(), self._settings.jog.mm_s * dt_s
        missing_mm = jog.goal_mm - wanted[jog.axis]
        if abs(missing_mm) <= most_mm:
            wanted[jog.axis] = jog.goal_mm
            return dataclasses.replace(state, jog=None), wanted
        wanted[jog.axis] += np.copysign(most_mm, missing_mm)
        return state, wanted

    def _found(self, state: LoopState, lost_motion_mm: Array, inputs: Inputs) -> Moved:
        """The search is over: every axis stands in the middle of its slack, which is called zero until the robot is straight."""
        state = dataclasses.replace(
            state,
            search=None,
            lost_motion_mm=lost_motion_mm,
            command_mm=self.taken_up(float(state.command_mm[-1])),
        )
        return Moved(state=self._straightening(state, inputs.now_s), renamed=True)

    def _follow(
        self, state: LoopState, task: Task, fresh: Seen | None, inputs: Inputs
    ) -> tuple[LoopState, Array]:
        task, wanted = tasks.advance(
            self._homing_law if state.mode is Mode.HOMING else self._law,
            task,
            fresh,
            command_mm=state.command_mm,
            drive=inputs.drive,
            now_s=inputs.now_s,
            dt_s=inputs.dt_s,
        )
        if state.mode is Mode.TRACKING:
            return dataclasses.replace(
                state, task=task, progress=task.reference.progress(inputs.now_s)
            ), wanted
        since_s = state.straight_since_s
        if fresh is not None:
            straight = task.straight(self._settings.homing.within_mm, inputs.now_s)
            since_s = min(since_s, inputs.now_s) if straight else np.inf
        return dataclasses.replace(state, task=task, straight_since_s=since_s), wanted

    def _limited(self, state: LoopState, wanted: Array, inputs: Inputs) -> Moved:
        try:
            limited = self._limits.apply(wanted, state.command_mm, inputs.dt_s)
        except CommandNotFiniteError as error:
            raise LawFailedError(str(error)) from error
        trouble = state.trouble.pushing("; ".join(limited.at_travel), inputs.now_s)
        state = dataclasses.replace(state, command_mm=limited.command_mm, trouble=trouble)
        return Moved(state=state, cut_short="; ".join((*limited.at_travel, *limited.at_rate)))

    def _may_follow(self, state: LoopState, now_s: float) -> bool:
        """Homing has no mode of its own for waiting, so it stands still here while no shape is trusted."""
        return state.mode is Mode.TRACKING or (
            state.mode is Mode.HOMING and not state.blind(now_s, self._settings.sensing.timeout_s)
        )


def _ended(state: LoopState, before: Mode, now_s: float) -> LoopState:
    """What the motion until now leaves: what its law learnt, where on the path it was, and, without torque, no target."""
    if before in (Mode.TRACKING, Mode.WAITING) and state.task is not None:
        state = dataclasses.replace(state, learnt=state.task.law_state)
    if before is Mode.TRACKING and state.task is not None:
        state = dataclasses.replace(state, joined_s=state.task.reference.path_s(now_s))
    return state if state.mode.torque else state.aimed(None)


def _left(state: LoopState) -> LoopState:
    """Without what belongs to other modes than the one that was entered."""
    return dataclasses.replace(
        state,
        search=state.search if state.mode is Mode.HOMING else None,
        jog=state.jog if state.mode in (Mode.HOLD, Mode.UNHOMED) else None,
        paused=state.paused and state.mode in (Mode.TRACKING, Mode.WAITING),
    )
