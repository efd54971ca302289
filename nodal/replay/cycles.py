"""The controller's cycles out of a log: what each one saw, put together from the topics that say it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from controller.cycle import Inputs, Request, Sighting
from drivers.actuators import ActuatorState
from messaging import topics
from messaging.control import ActionRequest, ControllerState, Target, TendonCommand, TendonState
from messaging.errors import NodalError
from messaging.history import Asked, Memory
from messaging.message import Message
from messaging.shape import ShapeEstimate
from nodal.replay.typed import read
from recordings.reader import Recorded

REQUESTS: dict[str, type[Message]] = {
    topics.CONTROLLER_DO.key: ActionRequest,
    topics.CONTROLLER_TARGET.key: Target,
    topics.STOP.key: ActionRequest,
}
"""What cycles are asked, by the key on which it comes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ControlPart:
    """A stretch of one log's cycles, in order, and what was said around them, by the cycle's `time_ns`.

    `shapes` are by capture time, ns. `asked` is None where a request is missing from the log, so that nothing can be said
    of any cycle.
    """

    states: Sequence[Recorded]
    tendons: Mapping[int, Recorded]
    commands: Mapping[int, Recorded]
    asked: Mapping[int, Sequence[Asked]]
    shapes: Mapping[int, Recorded]
    memories: Mapping[int, Memory]
    before: Memory | None
    """The memory with which the stretch begins, if there is one."""


class Unseen(NodalError):  # noqa: N818  a fact about a log rather than a fault
    """What a cycle saw is not in the log; the text says what."""


def inputs_of(
    state: ControllerState, part: ControlPart, shapes: Mapping[int, ShapeEstimate] | None
) -> Inputs:
    """What the cycle that ended in this state saw, with `shapes` in place of the logged ones if given; raises Unseen."""
    if not state.now_s:
        raise Unseen("the log was made by a version that did not say what cycles saw")
    return Inputs(
        now_s=state.now_s,
        dt_s=state.dt_s,
        sighting=_sighting(state, part, shapes),
        drive=_drive(state, part),
        absence=state.drive_absence,
        absence_fault=state.drive_fault,
        requests=tuple(request_of(asked) for asked in part.asked.get(state.time_ns, ())),
        heartbeat=state.heartbeat,
    )


def request_of(asked: Asked) -> Request:
    """The request in what was asked; raises CodecError or InvalidMessageError."""
    request = REQUESTS[asked.service].from_bytes(asked.request)
    if not isinstance(request, ActionRequest | Target):
        raise TypeError(f"{asked.service} takes a {type(request).__name__}")
    return request


def command_of(state: ControllerState, part: ControlPart) -> TendonCommand | None:
    """The command that this cycle wrote, if it did; raises Unseen when it is not in the log."""
    recorded = part.commands.get(state.time_ns)
    if recorded is None and state.commanded:
        raise Unseen("the cycle's command is missing from the log")
    return None if recorded is None else read(recorded, TendonCommand)


def _sighting(
    state: ControllerState, part: ControlPart, shapes: Mapping[int, ShapeEstimate] | None
) -> Sighting | None:
    captured_ns = state.sighted_capture_ns
    if not captured_ns:
        return None
    if shapes is not None and captured_ns in shapes:
        return Sighting(shape=shapes[captured_ns], age_s=state.sighted_age_s)
    if captured_ns not in part.shapes:
        raise Unseen("the shape that a cycle saw is missing from the log")
    return Sighting(shape=read(part.shapes[captured_ns], ShapeEstimate), age_s=state.sighted_age_s)


def _drive(state: ControllerState, part: ControlPart) -> ActuatorState | None:
    if state.drive_absence:
        return None
    if state.time_ns not in part.tendons:
        raise Unseen("the servos' report that a cycle saw is missing from the log")
    said = read(part.tendons[state.time_ns], TendonState)
    return ActuatorState(
        displacement_mm=said.displacement_mm,
        displacement_mm_s=said.displacement_mm_s,
        insertion_mm=said.insertion_mm,
        insertion_mm_s=said.insertion_mm_s,
        current_ma=said.current_ma,
        temperature_c=said.temperature_c,
        voltage_v=said.voltage_v,
        hardware_error=tuple(int(error) for error in np.asarray(said.hardware_error)),
        torque=said.torque,
        alarm=said.alarm,
    )
