"""What an operator would do by hand: home, arm, follow, relax; and begin anew when the controller fell out of it."""

import time

from messaging.control import Action, ActionRequest, Reply, State, Target
from messaging.errors import UnansweredError
from messaging.message import Message
from messaging.session import Session
from messaging.topics import CONTROLLER_DO, CONTROLLER_TARGET, Service
from nodal.demo.telemetry import Telemetry
from nodal.errors import DemoError
from nodal.processes.launcher import Launcher

ANSWER_WITHIN_S = 1.0
ARM_WITHIN_S = 45.0
RELAX_WITHIN_S = 8.0
ASK_AGAIN_AFTER_S = 0.5


class Operator:
    """Speaks to the controller, and waits in the launcher so that processes are tended meanwhile."""

    def __init__(self, session: Session, launcher: Launcher, telemetry: Telemetry) -> None:
        self._session = session
        self._launcher = launcher
        self._telemetry = telemetry

    def follow(self, target: Target, seconds: float) -> None:
        """Have this target followed for so long once that has begun, beginning anew when needed; raises DemoError."""
        self._begin(target)
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            self._launcher.turn()
            if self._telemetry.state in (State.IDLE, State.FAULT):
                self._begin(target)

    def relax(self) -> None:
        """Have the tendons let go, as far as anybody answers; never raises for want of an answer."""
        if self._asked(CONTROLLER_DO, ActionRequest(action=Action.RELAX)):
            return
        end_s = time.monotonic() + RELAX_WITHIN_S
        while time.monotonic() < end_s and self._telemetry.state not in (State.IDLE, None):
            time.sleep(0.05)
            self._telemetry.take()

    def _begin(self, target: Target) -> None:
        """Until the controller tracks this target; raises DemoError with its last refusal."""
        end_s = time.monotonic() + ARM_WITHIN_S
        refusal = ""
        while time.monotonic() < end_s:
            state = self._telemetry.state
            if state in (State.IDLE, State.FAULT):
                refusal = self._asked(CONTROLLER_DO, ActionRequest(action=Action.HOME))
            elif state is State.READY:
                refusal = self._asked(CONTROLLER_TARGET, target) or self._asked(
                    CONTROLLER_DO, ActionRequest(action=Action.ARM)
                )
            elif state is State.TRACKING:
                refusal = self._asked(CONTROLLER_TARGET, target)
                if not refusal:
                    return
            self._pause_in(state)
        raise DemoError(
            f"the controller did not follow target {target.name} within {ARM_WITHIN_S:g} s; "
            f"its state is {self._telemetry.state or 'unknown'}; {refusal or 'it refused nothing'}"
        )

    def _asked(self, service: Service, request: Message) -> str:
        """Ask; an empty text when it was accepted, the reason when it was not."""
        try:
            reply = self._session.ask(service, request, ANSWER_WITHIN_S)
        except UnansweredError as error:
            return str(error)
        return "" if isinstance(reply, Reply) and reply.accepted else str(getattr(reply, "reason", reply))

    def _pause_in(self, state: State | None) -> None:
        """A little while, or until the controller is no longer in this state."""
        end_s = time.monotonic() + ASK_AGAIN_AFTER_S
        self._launcher.turn()
        while time.monotonic() < end_s and self._telemetry.state is state:
            self._launcher.turn()
