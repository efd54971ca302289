"""What an operator asked, in words. Pure."""

from messaging.control import Action, ActionRequest, Target
from messaging.errors import CodecError, InvalidMessageError
from messaging.history import Asked
from messaging.message import Message
from messaging.recorder import RecorderRequest
from messaging.shape import NodalPoints
from messaging.topics import SERVICES, STOP


def request_in_words(asked: Asked) -> str:
    """The request; of one that cannot be read, why."""
    if asked.service == STOP.key:
        return "a stop signal"
    service = next((service for service in SERVICES if service.key == asked.service), None)
    if service is None:
        return f"{len(asked.request)} bytes to a service that this version does not know"
    try:
        return _words(service.request.from_bytes(asked.request))
    except (CodecError, InvalidMessageError) as error:
        return f"unreadable: {error}"


def target_in_words(target: Target) -> str:
    """Name, nodal points with their weights, and whether it is a pose or a path."""
    points = ", ".join(
        name if weight == 1 else f"{name} (weight {weight:g})"
        for name, weight in zip(target.node_names, target.weights, strict=True)
    )
    if len(target.time_s) == 1:
        places = "; ".join(", ".join(f"{value:.2f}" for value in place) for place in target.position_mm[0])
        return f"{target.name}: {points} to {places} mm"
    again = ", again and again" if target.repeat else ""
    return f"{target.name}: {points} through {len(target.time_s)} moments in {target.time_s[-1]:g} s{again}"


def _words(request: Message) -> str:
    match request:
        case ActionRequest(action=Action.JOG, axis=axis, distance_mm=distance_mm):
            return f"jog {axis} by {distance_mm:g} mm"
        case ActionRequest(action=action):
            return str(action)
        case Target():
            return target_in_words(request)
        case NodalPoints():
            named = zip(request.names, request.arc_mm, strict=True)
            return "nodal points " + ", ".join(f"{name} at {arc:g} mm" for name, arc in named)
        case RecorderRequest(action=action, file=file):
            return f"{action} {file}".strip()
    return type(request).__name__
