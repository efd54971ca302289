"""The edge to the bench's bus: the newest shape and its age, what operators ask, what the controller says."""

import logging
import time

from controller.cycle import Outputs, Request, Sighting
from messaging import topics
from messaging.control import ActionRequest, ControllerState, Reply, Target, TendonCommand, TendonState
from messaging.errors import CodecError, InvalidMessageError
from messaging.session import Query, Session
from messaging.shape import ShapeEstimate

logger = logging.getLogger(__name__)


class Wire:
    """Everything that one controller hears and says. Nothing here waits."""

    def __init__(self, session: Session, now_s: float) -> None:
        """Declare publishers, the subscription to shapes, and the services."""
        self._shapes = session.newest(topics.SHAPE)
        self._services = (session.answers(topics.CONTROLLER_DO), session.answers(topics.CONTROLLER_TARGET))
        self._target = session.publisher(topics.TARGET)
        self._command = session.publisher(topics.TENDON_COMMAND)
        self._state = session.publisher(topics.TENDON_STATE)
        self._controller = session.publisher(topics.CONTROLLER_STATE)
        self._looked_s = now_s
        self._asked: list[Query] = []

    def sighting(self, now_s: float) -> Sighting | None:
        """The newest shape that was not seen yet.

        Its age is what its publisher measured plus the time since. On one host that time is the difference of Unix
        times; clocks of two hosts may disagree, but a message cannot have waited here since before the last look.
        """
        at_most_s, self._looked_s = now_s - self._looked_s, now_s
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
        return Sighting(shape=shape, age_s=shape.capture_to_publish_ns * 1e-9 + waited_s)

    def requests(self) -> tuple[Request, ...]:
        """What was asked since the last cycle; what is not readable is answered at once."""
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
                    self._asked.append(query)
        return tuple(requests)

    def say(
        self,
        outputs: Outputs,
        command: TendonCommand | None,
        tendons: TendonState | None,
        controller: ControllerState,
    ) -> None:
        """Publish this cycle and answer what was asked in it."""
        if command is not None:
            self._command.put(command)
        if tendons is not None:
            self._state.put(tendons)
        self._controller.put(controller)
        if outputs.accepted is not None:
            self._target.put(outputs.accepted)
        for query, reply in zip(self._asked, outputs.replies, strict=True):
            query.reply(reply)
        self._asked.clear()
