"""`nodal do`: one action asked of the controller, answered with what happened and why not."""

import argparse
from typing import TYPE_CHECKING

from nodal.arguments import add_config_argument, add_timeout_argument

if TYPE_CHECKING:
    from messaging.control import Reply
    from messaging.session import Session

LISTEN_S = 1.0

ACTIONS = {
    "home": "take up slack and find the straight pose",
    "arm": "be ready to follow a target",
    "hold": "keep every tendon where it is",
    "relax": "let the tendons go",
    "stop": "stop at once, from any state",
    "status": "say the state and its reason",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The action."""
    meanings = "; ".join(f"{name}: {meaning}" for name, meaning in ACTIONS.items())
    parser.add_argument("action", choices=ACTIONS, help=meanings)
    add_config_argument(parser)
    add_timeout_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Ask the controller; 0 when it accepts, 3 when it refuses."""
    from messaging.control import Action, ActionRequest  # noqa: PLC0415
    from messaging.topics import CONTROLLER_DO  # noqa: PLC0415
    from nodal.asking import ask  # noqa: PLC0415

    request = ActionRequest(action=Action(arguments.action))
    if request.action is Action.STATUS:
        return ask(arguments.config, CONTROLLER_DO, request, arguments.timeout, _timeliness)
    return ask(arguments.config, CONTROLLER_DO, request, arguments.timeout)


def _timeliness(session: "Session", reply: "Reply") -> str:
    """Of the commands that are written just now."""
    from messaging.control import State  # noqa: PLC0415
    from nodal.timeliness import heard_within  # noqa: PLC0415

    return "" if reply.state in (State.IDLE, State.FAULT) else heard_within(session, LISTEN_S)
