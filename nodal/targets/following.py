"""Waiting until a target is done, by what the controller says of it."""

import dataclasses
import sys
import time

from messaging.control import ControllerState, State
from messaging.errors import CodecError, InvalidMessageError
from messaging.session import Session
from messaging.topics import CONTROLLER_STATE, HEARTBEAT
from nodal.exit_status import REFUSED

_LOOK_S = 0.05
_TELL_EVERY = 0.1
_ENDS = {False: (State.FAULT,), True: (State.FAULT, State.IDLE, State.HOMING, State.READY)}
"""States that end it, before it has begun and afterwards."""


@dataclasses.dataclass
class Following:
    """One target from its acceptance to its end. `turn` takes what the controller says and answers with how it ended."""

    target_name: str
    silence_s: float
    began: bool = False
    progress: float = 0.0
    told: float = -1.0
    heard_s: float = dataclasses.field(default_factory=time.monotonic)

    def turn(self, state: ControllerState, now_s: float) -> str | None:
        """Nothing while it goes on, an empty text when it arrived, and otherwise what ended it."""
        self.heard_s = now_s
        if state.state in _ENDS[self.began]:
            return f"{state.state}: {state.reason}"
        if state.target_name == self.target_name and state.state is State.TRACKING:
            self.began, self.progress = True, state.progress
            return "" if state.progress >= 1 else None
        if state.target_name not in ("", self.target_name):
            return f"target {state.target_name} took its place"
        # a hold keeps how far the target has come, and goes on from there; an abort forgets it
        if self.progress and not state.target_name and not state.progress:
            return f"{state.state}: {state.reason}"
        return None

    def silent(self, now_s: float) -> bool:
        """True when the controller has said nothing for too long."""
        return now_s - self.heard_s > self.silence_s


def follow(session: Session, target_name: str, silence_s: float) -> int:
    """Say how far the target has come until it has arrived (0) or something ended it (3); gives the operator's heartbeat."""
    heartbeat, states = session.gives(HEARTBEAT), session.newest(CONTROLLER_STATE)
    following = Following(target_name=target_name, silence_s=silence_s)
    ended: str | None = None
    while ended is None:
        heartbeat.give()
        try:
            said = states.take()
        except (CodecError, InvalidMessageError) as error:
            print(f"nodal: {error}", file=sys.stderr)
            said = None
        if said is not None and isinstance(said[0], ControllerState):
            ended = following.turn(said[0], time.monotonic())
            _tell(following, said[0])
        elif following.silent(time.monotonic()):
            ended = f"the controller has said nothing for {silence_s:g} s"
        time.sleep(_LOOK_S)
    if ended:
        print(f"nodal: target {target_name} did not arrive: {ended}", file=sys.stderr)
        return REFUSED
    print(f"target {target_name} arrived")
    return 0


def _tell(following: Following, state: ControllerState) -> None:
    if not following.began and following.told < 0 and state.state in (State.READY, State.HOLD):
        print(f"{state.state}: it begins with `nodal do arm`", flush=True)
        following.told = 0.0
    elif following.began and following.progress >= following.told + _TELL_EVERY:
        print(f"{100 * following.progress:3.0f} %  {state.tracking_error_mm:.2f} mm off", flush=True)
        following.told = following.progress
