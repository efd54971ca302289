"""One cycle of the controller: data in, data out, handed its time. Everything that decides is here or below.

A cycle looks (shape, drive), judges (faults, requests), and then moves as its mode demands.
"""

import dataclasses
from typing import TypeGuard

import numpy as np

from controller import task as tasks
from controller.cycle import Inputs, LoopState, Outputs, Request
from controller.errors import CommandNotFiniteError, LawFailedError, TargetError
from controller.motion import Motion
from controller.plant import Plant
from controller.reachability import check_target
from controller.settings import ControllerSettings
from controller.supervisor import Event, Happening, Mode, Supervision, next_state
from controller.task import Seen
from controller.watch import Trouble, distrust, drive_faults, motion_faults
from messaging.control import Action, ActionRequest, Reply, Target
from messaging.settings import RobotSettings


class Loop:
    """The controller of one robot."""

    def __init__(self, settings: ControllerSettings, robot: RobotSettings) -> None:
        """Raises ControllerSetupError when the settings do not fit the robot or name no law."""
        self._settings = settings
        self._plant = Plant.of(settings, robot)
        self._motion = Motion(settings, self._plant)
        self._untroubled = Trouble.none(self._plant.kinematics.axes)

    def start(self) -> LoopState:
        """In idle, knowing nothing."""
        return LoopState(
            supervision=Supervision(),
            command_mm=np.zeros(self._plant.kinematics.axes),
            trouble=self._untroubled,
        )

    def step(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Outputs]:
        """The state after this cycle and what is to be done."""
        before = state
        state, fresh = self._look(state, inputs)
        state, replies, accepted = self._judge(state, inputs)
        state = self._motion.prepare(
            state, before.mode, inputs.now_s, inputs.drive, retargeted=accepted is not None
        )
        try:
            state, cut_short = self._motion.move(state, before.mode, fresh, inputs)
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
        elif not why_not and state.mode is Mode.WAITING and state.target is not None:
            why_not = tasks.missing_nodes(state.target.node_names, shape)
        if why_not:
            return dataclasses.replace(state, distrusted=why_not), None
        seen = Seen(shape=shape, capture_s=capture_s, arrived_s=inputs.now_s)
        return dataclasses.replace(state, seen=seen, distrusted="none has come since"), seen

    def _judge(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, tuple[Reply, ...], Target | None]:
        """Faults first, then what was noticed, then what was asked."""
        unseen_s, blind = (
            state.unseen_s(inputs.now_s),
            state.blind(inputs.now_s, self._settings.sensing.timeout_s),
        )
        faults = motion_faults(state.supervision, unseen_s, state.distrusted, self._settings, inputs.now_s)
        trouble = self._untroubled
        if state.mode.torque:
            trouble, drive = drive_faults(
                inputs.drive,
                inputs.absence,
                state.trouble,
                settings=self._settings,
                limits=self._plant.limits,
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
                check_target(request, arcs, self._plant, self._settings)
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
        straight_s = now_s - state.straight_since_s
        if state.mode is Mode.HOMING and not blind and straight_s > self._settings.homing.settle_s:
            return [Happening(event=Event.HOMED, reason="homed")]
        if state.mode is Mode.RELAXING and not state.command_mm[:-1].any():
            return [Happening(event=Event.RELAXED, reason="relaxed")]
        return []

    def _reason(self, state: LoopState, inputs: Inputs) -> str:
        """Why the mode is what it is; an absent drive is no fault in idle, but it is worth saying."""
        if state.mode is Mode.IDLE and inputs.drive is None:
            return inputs.absence
        return state.supervision.reason


def _is_order(request: Request) -> TypeGuard[ActionRequest]:
    return isinstance(request, ActionRequest) and request.action is not Action.STATUS
