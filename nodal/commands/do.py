"""`nodal do`: one action asked of the controller, answered with what happened and why not."""

import argparse
import math
from typing import TYPE_CHECKING

from nodal.arguments import add_config_argument, add_timeout_argument
from nodal.errors import CommandError

if TYPE_CHECKING:
    from messaging.control import ActionRequest, Reply
    from messaging.session import Session

LISTEN_S = 1.0

ACTIONS = {
    "home": "find the slack of every tendon, then the straight pose",
    "arm": "be ready to follow a target",
    "hold": "keep every tendon where it is",
    "pause": "slow down along the path to a stand",
    "resume": "go on after a pause",
    "abort": "give the target up and hold",
    "jog": "move one axis slowly: jog AXIS MM, with the number of a tendon (or pair) or `stage`",
    "relax": "let the tendons go",
    "stop": "stop at once, from any state",
    "status": "say the state, its reason, and what to do about a fault",
    "watch": "say them live until Ctrl-C, and give the operator's heartbeat meanwhile",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The action, and what a jog needs."""
    meanings = "; ".join(f"{name}: {meaning}" for name, meaning in ACTIONS.items())
    parser.add_argument("action", choices=ACTIONS, help=meanings)
    parser.add_argument(
        "jog", nargs="*", default=[], metavar="AXIS MM", help="of a jog: which axis, and how far"
    )
    add_config_argument(parser)
    add_timeout_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Ask the controller; 0 when it accepts, 3 when it refuses. Raises CommandError."""
    from messaging.control import Action  # noqa: PLC0415
    from messaging.topics import CONTROLLER_DO  # noqa: PLC0415
    from nodal.asking import ask  # noqa: PLC0415
    from nodal.watching import watch  # noqa: PLC0415

    if arguments.action == "watch":
        return watch(arguments.config)
    request = _request(arguments.action, arguments.jog)
    if request.action is Action.STATUS:
        return ask(arguments.config, CONTROLLER_DO, request, arguments.timeout, _timeliness)
    return ask(arguments.config, CONTROLLER_DO, request, arguments.timeout)


def _request(action: str, jog: list[str]) -> "ActionRequest":
    from messaging.control import Action, ActionRequest  # noqa: PLC0415

    if action != Action.JOG:
        if jog:
            raise CommandError(f"do {action} takes nothing more, not {' '.join(jog)}")
        return ActionRequest(action=Action(action))
    try:
        axis, distance = jog
        distance_mm = float(distance)
    except ValueError:
        distance_mm = math.nan
    if not math.isfinite(distance_mm):
        raise CommandError(
            f"do jog takes AXIS MM, such as 2 0.5 or stage -1, not {' '.join(jog) or 'nothing'}"
        )
    return ActionRequest(action=Action.JOG, axis=axis, distance_mm=distance_mm)


def _timeliness(session: "Session", reply: "Reply") -> str:
    """Of the commands that are written just now."""
    from messaging.control import State  # noqa: PLC0415
    from nodal.timeliness import heard_within  # noqa: PLC0415

    return "" if reply.state in (State.IDLE, State.FAULT) else heard_within(session, LISTEN_S)
