"""`nodal do`: one action asked of the controller, answered with what happened and why not."""

import argparse

from nodal.arguments import add_config_argument, add_timeout_argument

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

    return ask(
        arguments.config, CONTROLLER_DO, ActionRequest(action=Action(arguments.action)), arguments.timeout
    )
