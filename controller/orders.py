"""What is asked of the loop: why it cannot be done whatever the mode, and what is answered. Pure."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import TypeGuard

import numpy as np

from controller import task as tasks
from controller.cycle import Asked, Inputs, Jog, LoopState, Request
from controller.errors import FaultError, TargetError
from controller.limits import axis_name
from controller.motion import FORGETTING, Motion
from controller.path import along
from controller.planning.space import Space
from controller.plant import Plant
from controller.reachability import check_target, say_too_close
from controller.settings import ControllerSettings
from controller.supervisor import Mode, Supervision
from controller.watch import TRAVEL_TOLERANCE_MM
from messaging.control import Action, ActionRequest, Reply, Target

_NEED_SHAPES = (Action.HOME, Action.ARM)
_NEED_DRIVE = (Action.HOME, Action.JOG)
_NEED_HEARTBEAT = (Action.HOME, Action.ARM, Action.RESUME, Action.JOG)
_HOMED_FOR_JOGS = (Mode.READY, Mode.HOLD)
_JOG_PLACES = 6
"""At so many places of a jog's way it is looked at how near regions are."""
_NEARER_MM = 1e-6
_LARGEST_TARGET = 5000
"""Positions of a target, moments times nodal points: more take longer to be looked at than a few cycles."""


def is_order(request: Request) -> TypeGuard[ActionRequest]:
    """True for what may change the mode."""
    return isinstance(request, ActionRequest) and request.action is not Action.STATUS


def void(request: Request, beside: Sequence[Request], faults: Sequence[FaultError]) -> str:
    """Why a request is void because of what came in the same cycle; nothing when it is not.

    A fault and a stop spare stops and questions for the status alone; of several targets the last one counts.
    """
    stop = any(is_order(other) and other.action is Action.STOP for other in beside)
    if isinstance(request, Target):
        what = f"target {request.name}"
        last = next(other for other in reversed(beside) if isinstance(other, Target))
        why = f"target {last.name} came in the same cycle" if last is not request else ""
    elif request.action in (Action.STOP, Action.STATUS):
        return ""
    else:
        what, why = str(request.action), ""
    if faults:
        why = str(faults[0])
    elif stop:
        why = "a stop came in the same cycle"
    return f"{what} is void: {why}" if why else ""


def replies(
    requests: Sequence[Request], refusals: Sequence[str], supervision: Supervision, reason: str
) -> tuple[Reply, ...]:
    """One for each request, with what came of it in this cycle; `reason` says why the mode is what it is."""
    return tuple(
        Reply(
            accepted=not refusal,
            state=supervision.mode.state.value,
            reason=refusal or (f"target {request.name} accepted" if isinstance(request, Target) else reason),
            **supervision.told,
        )
        for request, refusal in zip(requests, refusals, strict=True)
    )


class Orders:
    """The orders that one robot can be given."""

    def __init__(self, settings: ControllerSettings, plant: Plant, motion: Motion) -> None:
        """Checked against these settings."""
        self._settings = settings
        self._plant = plant
        self._motion = motion
        self._space = Space(plant)
        self._axes = {str(axis + 1): axis for axis in range(plant.kinematics.tendons)}
        if plant.kinematics.stage:
            self._axes["stage"] = plant.kinematics.tendons

    def refusals(self, state: LoopState, inputs: Inputs, faults: Sequence[FaultError]) -> list[str]:
        """For each request why it cannot be done whatever the mode, beside these faults; nothing where it can."""
        refusals = []
        for request in inputs.requests:
            refusal = void(request, inputs.requests, faults) or self._refusal(request, state, inputs)
            refusals.append(refusal)
            # what comes behind in the same cycle is judged by the target that there is then
            if not refusal and isinstance(request, Target):
                state = state.aimed(request)
            elif not refusal and is_order(request) and request.action in FORGETTING:
                state = state.aimed(None)
        return refusals

    def _refusal(self, request: Request, state: LoopState, inputs: Inputs) -> str:
        if isinstance(request, Target):
            return self._target_refusal(request, state, inputs.now_s)
        return next(self._reasons(request, state, inputs), "")

    def _reasons(self, request: ActionRequest, state: LoopState, inputs: Inputs) -> Iterator[str]:
        action, seen = request.action, state.seen
        heartbeat_s, unheard_s = self._settings.operator.heartbeat_s, inputs.now_s - state.heartbeat_s
        if action in _NEED_DRIVE and inputs.drive is None:
            yield f"no tendon drive: {inputs.absence}"
        if action in _NEED_DRIVE and inputs.drive is not None:
            yield from filter(None, [self._stage_refusal(inputs.drive.insertion_mm)])
        if action in _NEED_HEARTBEAT and heartbeat_s and unheard_s > heartbeat_s:
            yield f"no operator's heartbeat within {heartbeat_s:g} s; `nodal do watch` gives one"
        blind = seen is None or state.blind(inputs.now_s, self._settings.sensing.timeout_s)
        if action in _NEED_SHAPES and blind:
            yield f"no trusted shape: {state.distrusted}"
        if action is Action.ARM and seen is not None and state.target is not None:
            yield from filter(None, [tasks.missing_nodes(state.target.node_names, seen.shape)])
            if len(self._plant.regions) and state.mode is not Mode.TRACKING:
                joins = dataclasses.replace(
                    state.target,
                    time_s=np.zeros(1),
                    position_mm=along(state.target, state.joined_s).node_mm[None],
                    repeat=False,
                    repeat_from_s=0.0,
                )
                yield from filter(None, [self._target_refusal(joins, state, inputs.now_s)])
        if action is Action.JOG:
            yield from self._jog_reasons(request, state, inputs)

    def asked(self, request: Request, state: LoopState, inputs: Inputs) -> Asked:
        """What a request that is not refused means to the motion."""
        if isinstance(request, Target):
            return request
        return self._jog(request, state, inputs) if request.action is Action.JOG else request.action

    def _jog(self, request: ActionRequest, state: LoopState, inputs: Inputs) -> Jog:
        axis = self._axes[request.axis]
        begin_mm = state.command_mm
        if not state.mode.torque and inputs.drive is not None:
            begin_mm = self._motion.taken_up(inputs.drive.insertion_mm)
        return Jog(
            axis=axis,
            goal_mm=float(begin_mm[axis]) + request.distance_mm,
            words=f"the operator jogs {axis_name(axis, self._plant.limits.tendons)} by {request.distance_mm:g} mm",
        )

    def _stage_refusal(self, insertion_mm: float) -> str:
        """A stage keeps its zero through homing, so one that stands where it cannot be has lost it: nothing may move by it."""
        low_mm, high_mm = self._plant.limits.stage_mm
        if low_mm - TRAVEL_TOLERANCE_MM <= insertion_mm <= high_mm + TRAVEL_TOLERANCE_MM:
            return ""
        return (
            f"the stage stands at {insertion_mm:.3f} mm, travel {low_mm:g} to {high_mm:g} mm: turn it back by hand; "
            "if it does not stand there, its zero is wrong (docs/servos.md)"
        )

    def _target_refusal(self, target: Target, state: LoopState, now_s: float) -> str:
        if target.position_mm.size // 3 > _LARGEST_TARGET:
            return (
                f"target {target.name}: {len(target.time_s)} moments of {len(target.node_names)} nodal points; "
                f"their product may be {_LARGEST_TARGET} at most"
            )
        seen = state.seen
        arcs = {} if seen is None else dict(zip(seen.shape.node_names, seen.shape.node_arc_mm, strict=True))
        start_mm = None
        if seen is not None and not tasks.missing_nodes(target.node_names, seen.shape):
            led = state.task if state.mode is Mode.TRACKING else None
            start_mm = tasks.starting_points(target, seen, led, now_s).node_mm
        try:
            check_target(target, arcs, self._plant, self._settings, start_mm=start_mm)
        except TargetError as error:
            return str(error)
        return ""

    def _jog_reasons(self, request: ActionRequest, state: LoopState, inputs: Inputs) -> Iterator[str]:
        at_most_mm, distance_mm = self._settings.jog.at_most_mm, request.distance_mm
        if request.axis not in self._axes:
            yield f"there is no axis {request.axis!r}; known are {', '.join(self._axes)}"
        if not 0 < abs(distance_mm) <= at_most_mm:
            yield f"a jog of {distance_mm:g} mm: it must be some way, and at most {at_most_mm:g} mm"
        jog, limits = self._jog(request, state, inputs), self._plant.limits
        low_mm, high_mm = limits.low_mm[jog.axis], limits.high_mm[jog.axis]
        if not low_mm <= jog.goal_mm <= high_mm:
            yield (
                f"{axis_name(jog.axis, limits.tendons)} would come to {jog.goal_mm:g} mm; "
                f"its travel is {low_mm:g} to {high_mm:g} mm"
            )
        if state.mode in _HOMED_FOR_JOGS and len(self._plant.regions):
            yield from filter(None, [self._encroachment(jog, state)])

    def _encroachment(self, jog: Jog, state: LoopState) -> str:
        """Whether the model of a homed robot comes too near to a region on the way, and nearer than it is."""
        way = np.tile(state.command_mm, (_JOG_PLACES, 1))
        way[:, jog.axis] = np.linspace(way[0, jog.axis], jog.goal_mm, _JOG_PLACES)
        configurations = way @ self._plant.kinematics.coordinates_of_command.T
        nearest, now = (self._space.nearest(places) for places in (configurations, configurations[:1]))
        if nearest is None or now is None or nearest.spare_mm > min(now.spare_mm - _NEARER_MM, 0.0):
            return ""
        return f"on the way of this jog {say_too_close(nearest, self._plant)}"
