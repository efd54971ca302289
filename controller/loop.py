"""One cycle of the controller: data in, data out, handed its time. Everything that decides is here or below.

A cycle looks (shape, drive), judges (faults, requests), and then moves as its mode demands.
"""

import dataclasses

import numpy as np

from controller import task as tasks
from controller.checked import checked
from controller.cycle import Asked, Inputs, LoopState, Outputs
from controller.errors import FaultError
from controller.motion import Motion, Moved
from controller.orders import Orders, is_order, replies, void
from controller.plant import Plant
from controller.settings import ControllerSettings
from controller.supervisor import Event, Happening, Mode, Supervision, next_state
from controller.task import Seen
from controller.watch import Trouble, Watch, distrust
from messaging.control import Action, Target
from messaging.settings import RobotSettings


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class _Judged:
    """What came of a cycle's requests: for each why it was refused, if it was; and what the others ask of the motion."""

    state: LoopState
    refusals: list[str]
    asked: tuple[Asked, ...]


class Loop:
    """The controller of one robot."""

    def __init__(self, settings: ControllerSettings, robot: RobotSettings) -> None:
        """Raises ControllerSetupError when the settings do not fit the robot or name no law."""
        self._settings = settings
        self._plant = Plant.of(settings, robot)
        self._motion = Motion(settings, self._plant)
        self._orders = Orders(settings, self._plant, self._motion)
        self._watch = Watch(settings, self._plant)
        self._untroubled = Trouble.none(self._plant.kinematics.axes)

    def start(self) -> LoopState:
        """In idle, knowing nothing."""
        axes = self._plant.kinematics.axes
        return LoopState(
            supervision=Supervision(),
            command_mm=np.zeros(axes),
            trouble=self._untroubled,
            lost_motion_mm=np.full(axes, np.nan),
        )

    def step(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Outputs]:
        """The state after this cycle and what is to be done; raises ClockError for a time that is none."""
        inputs = checked(inputs, self._plant.kinematics.tendons, self._plant.kinematics.axes)
        before = state
        state, fresh = self._look(state, inputs)
        judged = self._judge(state, fresh, inputs)
        judged, moved = self._move(judged, before.mode, fresh, inputs)
        state = dataclasses.replace(moved.state, stepped_s=inputs.now_s)
        engage = state.mode.torque and not before.mode.torque
        homed = state.mode is Mode.READY and before.mode is Mode.HOMING
        reason = self._reason(state, inputs)
        powered = before.mode.torque or (inputs.drive is not None and inputs.drive.torque)
        named = inputs.drive if homed or engage or moved.renamed else None
        return state, Outputs(
            tendons=self._plant.kinematics.tendons,
            release=powered and not state.mode.torque,
            engage=engage,
            zero_mm=None if named is None else self._motion.named_zero(named.insertion_mm),
            command_mm=state.command_mm if state.mode.torque else None,
            replies=replies(inputs.requests, judged.refusals, state.supervision, reason),
            accepted=state.target if any(asked is state.target for asked in judged.asked) else None,
            reason=moved.cut_short or reason,
        )

    def _look(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Seen | None]:
        """Take in whether somebody is there, and a new shape, if it may be acted on."""
        if inputs.heartbeat:
            state = dataclasses.replace(state, heartbeat_s=inputs.now_s)
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

    def _judge(self, state: LoopState, fresh: Seen | None, inputs: Inputs) -> _Judged:
        """Faults first, then what was asked, then what was noticed: so an order finds the mode that its operator saw."""
        trouble: Trouble = self._untroubled
        faults: list[FaultError] = []
        if state.mode.torque:
            trouble, faults = self._faults(state, fresh, inputs)
        refusals = self._orders.refusals(state, inputs, faults)
        noticed = self._noticed(state, inputs.now_s)
        orders = [
            Happening(event=Event(request.action.value), reason=f"the operator asked to {request.action}")
            for request, refusal in zip(inputs.requests, refusals, strict=True)
            if is_order(request) and not refusal
        ]
        supervision, allowed = next_state(state.supervision, [*orders, *noticed], faults, inputs.now_s)
        outcome = iter(allowed)
        for index, request in enumerate(inputs.requests):
            if is_order(request) and not refusals[index] and not next(outcome):
                refusals[index] = f"{request.action} is not possible in {state.mode}: {supervision.reason}"
        accepted = [
            request
            for request, refusal in zip(inputs.requests, refusals, strict=True)
            if not refusal and (is_order(request) or isinstance(request, Target))
        ]
        # nobody watches any more: that is as good as an order to hold
        lost = [Action.HOLD for happening in noticed if happening.event is Event.OPERATOR_LOST]
        return _Judged(
            state=dataclasses.replace(state, supervision=supervision, trouble=trouble),
            refusals=refusals,
            asked=(*(self._orders.asked(request, state, inputs) for request in accepted), *lost),
        )

    def _faults(
        self, state: LoopState, fresh: Seen | None, inputs: Inputs
    ) -> tuple[Trouble, list[FaultError]]:
        """What must not go on while torque is on, the worst first."""
        watch, now_s, mode = self._watch, inputs.now_s, state.mode
        trouble, faults = state.trouble, []
        if inputs.drive is None:
            faults.append(watch.absent(inputs.absence, inputs.absence_fault))
        else:
            trouble, faults = watch.drive(inputs.drive, state.command_mm, trouble, now_s)
        faults += watch.pushed(trouble, now_s) + watch.cycle(now_s - state.stepped_s)
        if fresh is not None:
            faults += watch.body(fresh.shape)
        if mode in (Mode.HOMING, Mode.WAITING):
            faults += watch.unseen(state.unseen_s(now_s), state.distrusted)
        if mode is Mode.HOMING:
            faults += watch.straightening(state.straightening_since_s, now_s)
        if mode is not Mode.RELAXING:
            faults += watch.operator(now_s - state.heartbeat_s)
        return trouble, faults

    def _noticed(self, state: LoopState, now_s: float) -> list[Happening]:
        noticed = []
        blind = state.blind(now_s, self._settings.sensing.timeout_s)
        if state.mode is Mode.TRACKING and blind:
            reason = f"no trusted shape: {state.distrusted}"
            noticed.append(Happening(event=Event.SENSING_LOST, reason=reason))
        if state.mode is Mode.WAITING and not blind:
            noticed.append(Happening(event=Event.SENSING_GOOD, reason="shapes are trusted again"))
        straight_s = now_s - state.straight_since_s
        if state.mode is Mode.HOMING and not blind and straight_s > self._settings.homing.settle_s:
            noticed.append(Happening(event=Event.HOMED, reason=_homed(state)))
        if state.mode is Mode.RELAXING and not state.command_mm[: self._plant.kinematics.tendons].any():
            noticed.append(Happening(event=Event.RELAXED, reason="relaxed"))
        heartbeat_s = self._settings.operator.heartbeat_s
        watched = state.mode in (Mode.HOMING, Mode.TRACKING, Mode.WAITING) or state.jog is not None
        if watched and 0 < heartbeat_s < now_s - state.heartbeat_s:
            reason = f"no operator's heartbeat for more than {heartbeat_s:g} s"
            noticed.append(Happening(event=Event.OPERATOR_LOST, reason=reason))
        return noticed

    def _move(
        self, judged: _Judged, before: Mode, fresh: Seen | None, inputs: Inputs
    ) -> tuple[_Judged, Moved]:
        """As the mode demands; what fails on the way ends in a fault in this cycle, with what was asked in it void."""
        state = judged.state
        try:
            state = self._motion.prepare(state, before, inputs, judged.asked)
            return judged, self._motion.move(state, before, fresh, inputs)
        except FaultError as error:
            state = dataclasses.replace(state, supervision=Supervision.failed(error, inputs.now_s))
            refusals = [
                refusal or void(request, inputs.requests, [error])
                for request, refusal in zip(inputs.requests, judged.refusals, strict=True)
            ]
            judged = _Judged(state=state, refusals=refusals, asked=())
            return judged, Moved(state=self._motion.prepare(state, before, inputs, ()))

    def _reason(self, state: LoopState, inputs: Inputs) -> str:
        """Why the mode is what it is; an absent drive is no fault in idle, but it is worth saying."""
        if state.mode is Mode.IDLE and inputs.drive is None:
            return inputs.absence
        return self._motion.doing(state) or state.supervision.reason


def _homed(state: LoopState) -> str:
    """What homing found."""
    found = [f"{lost_mm:.2f}" for lost_mm in state.lost_motion_mm.tolist() if np.isfinite(lost_mm)]
    return f"homed; lost motion {', '.join(found)} mm" if found else "homed"
