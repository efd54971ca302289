"""The edge to the bench's bus: the newest shape and its age, what operators ask, what the controller says."""

import logging
import time

from controller.account import Account
from controller.cycle import LoopState, Outputs, Request, Sighting
from messaging import topics
from messaging.control import Action, ActionRequest, Reply, Target
from messaging.errors import CodecError, InvalidMessageError
from messaging.history import Asked, Memory
from messaging.session import Query, Session
from messaging.shape import ShapeEstimate
from messaging.views import DesiredPointsView, TargetPathView

logger = logging.getLogger(__name__)

STOP_REQUEST = ActionRequest(action=Action.STOP)
"""What a stop signal asks."""


class Wire:
    """Everything that one controller hears and says. Nothing here waits."""

    def __init__(self, session: Session, now_s: float) -> None:
        """Declare publishers, the subscription to shapes, and the services."""
        self._shapes = session.newest(topics.SHAPE)
        self._stop = session.hears(topics.STOP)
        self._heartbeat = session.hears(topics.HEARTBEAT)
        self._services = (session.answers(topics.CONTROLLER_DO), session.answers(topics.CONTROLLER_TARGET))
        self._target = session.publisher(topics.TARGET)
        self._command = session.publisher(topics.TENDON_COMMAND)
        self._tendons = session.publisher(topics.TENDON_STATE)
        self._controller = session.publisher(topics.CONTROLLER_STATE)
        self._path = session.publisher(topics.TARGET_PATH)
        self._desired = session.publisher(topics.DESIRED_POINTS)
        self._asked = session.publisher(topics.ASKED)
        self._memory = session.publisher(topics.CONTROLLER_MEMORY)
        self._looked_s = now_s
        self._asking: list[tuple[str, bytes, Query | None]] = []

    def sighting(self, now_s: float) -> Sighting | None:
        """The newest shape that was not seen yet, and its age at `now_s`, which may be a little ago.

        The age is what its publisher measured plus the time since. On one host that time is the difference of Unix
        times; clocks of two hosts may disagree, but a message cannot have waited here since before the last look.
        """
        looked_s = time.monotonic()
        at_most_s, self._looked_s = looked_s - self._looked_s, looked_s
        try:
            taken = self._shapes.take()
        except (CodecError, InvalidMessageError) as error:
            logger.warning("a shape was not readable: %s", error)
            return None
        if taken is None:
            return None
        shape, envelope = taken
        if not isinstance(shape, ShapeEstimate):
            raise TypeError(f"{topics.SHAPE.key} carries a {type(shape).__name__}")
        waited_s = min(max((time.time_ns() - envelope.publish_time_ns) * 1e-9, 0.0), at_most_s)
        age_s = shape.capture_to_publish_ns * 1e-9 + waited_s - (looked_s - now_s)
        return Sighting(shape=shape, age_s=age_s)

    def requests(self) -> tuple[Request, ...]:
        """What was asked since the last cycle; what is not readable is answered at once. A stop signal waits for no answer."""
        requests: list[Request] = []
        for service in self._services:
            while (query := service.take()) is not None:
                try:
                    request = query.request()
                except (CodecError, InvalidMessageError) as error:
                    query.reply(Reply(accepted=False, state="", reason=str(error)))
                    continue
                if isinstance(request, ActionRequest | Target):
                    requests.append(request)
                    self._asking.append((query.service.key, query.payload, query))
        if self._stop.heard():
            requests.append(STOP_REQUEST)
            self._asking.append((topics.STOP.key, STOP_REQUEST.to_bytes(), None))
        return tuple(requests)

    def heartbeat(self) -> bool:
        """True when an operator's heartbeat came since the last cycle."""
        return self._heartbeat.heard()

    def say(self, outputs: Outputs, account: Account) -> int:
        """Publish this cycle and answer what was asked in it; returns the number of its state."""
        if account.command is not None:
            self._command.put(account.command)
        if account.tendons is not None:
            self._tendons.put(account.tendons)
        controller = account.controller
        number = self._controller.put(controller)
        if outputs.accepted is not None:
            self._target.put(outputs.accepted)
            self._path.put(TargetPathView.of(outputs.accepted, controller.time_ns))
        if account.fresh and controller.node_names:
            self._desired.put(DesiredPointsView.of(controller))
        for (key, payload, query), reply in zip(self._asking, outputs.replies, strict=True):
            self._asked.put(Asked.of(key, payload, reply, controller.time_ns))
            if query is not None:
                query.reply(reply)
        self._asking.clear()
        return number

    def say_memory(self, state: LoopState, time_ns: int, publication: int) -> None:
        """Publish what this cycle leaves to the next, as far as a law remembers what can be kept."""
        try:
            content = state.to_bytes()
        except CodecError as error:
            logger.warning("no replay can begin here: %s", error)
            return
        self._memory.put(Memory(time_ns=time_ns, content=content, publication=publication))
