"""What is asked of the loop: why it cannot be done whatever the mode, and what is answered. Pure."""

from collections.abc import Iterator, Sequence
from typing import TypeGuard

from controller import task as tasks
from controller.cycle import Asked, Inputs, Jog, LoopState, Request
from controller.errors import TargetError
from controller.limits import axis_name
from controller.motion import Motion
from controller.plant import Plant
from controller.reachability import check_target
from controller.settings import ControllerSettings
from controller.supervisor import Mode, Supervision
from messaging.control import Action, ActionRequest, Reply, Target

_NEED_SHAPES = (Action.HOME, Action.ARM)
_NEED_DRIVE = (Action.HOME, Action.JOG)
_NEED_HEARTBEAT = (Action.HOME, Action.ARM, Action.RESUME, Action.JOG)


def is_order(request: Request) -> TypeGuard[ActionRequest]:
    """True for what may change the mode."""
    return isinstance(request, ActionRequest) and request.action is not Action.STATUS


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
        self._axes = {str(axis + 1): axis for axis in range(plant.kinematics.tendons)}
        if plant.kinematics.stage:
            self._axes["stage"] = plant.kinematics.tendons

    def refusal(self, request: Request, state: LoopState, inputs: Inputs) -> str:
        """Why what was asked cannot be done whatever the mode; nothing when it can."""
        if isinstance(request, Target):
            return self._target_refusal(request, state, inputs.now_s)
        return next(self._reasons(request, state, inputs), "")

    def _reasons(self, request: ActionRequest, state: LoopState, inputs: Inputs) -> Iterator[str]:
        action, seen = request.action, state.seen
        heartbeat_s, unheard_s = self._settings.operator.heartbeat_s, inputs.now_s - state.heartbeat_s
        if action in _NEED_DRIVE and inputs.drive is None:
            yield f"no tendon drive: {inputs.absence}"
        if action in _NEED_HEARTBEAT and heartbeat_s and unheard_s > heartbeat_s:
            yield f"no operator's heartbeat within {heartbeat_s:g} s; `nodal do watch` gives one"
        blind = seen is None or state.blind(inputs.now_s, self._settings.sensing.timeout_s)
        if action in _NEED_SHAPES and blind:
            yield f"no trusted shape: {state.distrusted}"
        if action is Action.ARM and seen is not None and state.target is not None:
            yield from filter(None, [tasks.missing_nodes(state.target.node_names, seen.shape)])
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

    def _target_refusal(self, target: Target, state: LoopState, now_s: float) -> str:
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
