"""docs/faults.md out of the controller's faults and modes: `python -m nodal.fault_reference > docs/faults.md`."""

import inspect
from collections.abc import Iterator

from controller.faults import FAULTS
from controller.supervisor import TRANSITIONS, Event, Mode
from messaging.control import Action

HEADER = """# Faults, states, and what leads out of them

Made from `controller/faults.py` and `controller/supervisor.py` by `python -m nodal.fault_reference`; a test keeps it in step.

A fault ends everything at once: in the cycle that finds it (5 ms at 200 Hz) the servos let all tendons go, and the state is
`fault`. Slack tendons cannot hurt the robot, the backbone straightens by itself, and the stage's screw keeps its place without
torque. Nothing but an operator's `nodal do home` or `nodal do relax` leads out of it: what was wrong may be right again, and
still nothing moves. A restart of the controller begins in `idle` and arms nothing.

`nodal do status` says the state, the reason with its value and limit, and what to do. The same stands in the messages
`ControllerState` and `Reply` (messages.md): `fault` is the code below, `fault_value` and `fault_limit` are numbers of
`fault_unit`, `advice` is the last column. So they stand in every recording.
"""
WHEN = {
    Event.HOMED: "the robot is straight",
    Event.RELAXED: "all tendons are back at zero",
    Event.SENSING_LOST: "no trusted shape for `controller.sensing.timeout_s`",
    Event.SENSING_GOOD: "shapes are trusted again",
    Event.OPERATOR_LOST: "no heartbeat for `controller.operator.heartbeat_s`",
}
SAME = "stays"
NOTHING = ""


def reference() -> str:
    """The whole text."""
    return "\n".join((HEADER, *_faults(), *_states())) + "\n"


def _faults() -> Iterator[str]:
    yield "## Faults\n"
    yield "| code | what happened | what to do |"
    yield "|---|---|---|"
    for code, kind in FAULTS.items():
        yield f"| `{code}` | {' '.join(inspect.cleandoc(kind.__doc__ or '').split())} | {kind.advice} |"


def _states() -> Iterator[str]:
    yield "\n## States\n"
    yield (
        "What each order and each event leads to, from each state; an empty place is an order that is refused, or an event that "
        "cannot be. `waiting` (for shapes) and `relaxing` are told as `hold`, with their reason. A stop, and a fault, make "
        "everything void that is asked in the same cycle.\n"
    )
    yield f"| | {' | '.join(Mode)} |"
    yield f"|---|{'---|' * len(Mode)}"
    orders = [Event(action.value) for action in Action if action is not Action.STATUS]
    for event in (*orders, *WHEN):
        cells = " | ".join(_cell(mode, event) for mode in Mode)
        yield f"| {WHEN.get(event, f'`{event}`')} | {cells} |"
    torque = " | ".join("on" if mode.torque else "off" for mode in Mode)
    yield f"| *torque* | {torque} |"


def _cell(mode: Mode, event: Event) -> str:
    following = TRANSITIONS.get((mode, event))
    if following is None:
        return NOTHING
    return SAME if following is mode else str(following)


if __name__ == "__main__":
    print(reference(), end="")
