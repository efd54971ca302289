"""The newest word of sensing and of the controller, and how often each speaks."""

import time
from collections import deque

from messaging import topics
from messaging.control import ControllerState, State
from messaging.session import Newest, Received, Session
from messaging.shape import ShapeEstimate
from nodal.timeliness import Timeliness

RATE_WINDOW_S = 2.0
SILENT_AFTER_S = 1.0


class Telemetry:
    """Hears what the demo acts on and shows. Call `take` often."""

    def __init__(self, session: Session) -> None:
        self._shapes = _Heard(session.newest(topics.SHAPE))
        self._states = _Heard(session.newest(topics.CONTROLLER_STATE))
        self.timeliness = Timeliness(session)

    def take(self) -> None:
        """Hear what is new; never waits."""
        self._shapes.take()
        self._states.take()
        self.timeliness.take()

    @property
    def shape(self) -> ShapeEstimate | None:
        """The newest estimate; None when sensing is silent."""
        message = self._shapes.message
        return message if isinstance(message, ShapeEstimate) else None

    @property
    def controller(self) -> ControllerState | None:
        """The newest state; None when the controller is silent."""
        message = self._states.message
        return message if isinstance(message, ControllerState) else None

    @property
    def state(self) -> State | None:
        """The controller's state; None when it is silent."""
        return self.controller.state if self.controller else None

    @property
    def shape_rate_hz(self) -> float:
        """Estimates a second."""
        return self._shapes.rate_hz

    @property
    def control_rate_hz(self) -> float:
        """Cycles a second."""
        return self._states.rate_hz


class _Heard:
    def __init__(self, newest: Newest) -> None:
        self._newest = newest
        self._message: object = None
        self._counts: deque[tuple[float, int, int]] = deque()

    def take(self) -> None:
        heard = self._newest.take()
        if heard is not None:
            self._message, received = heard
            self._count(received)

    @property
    def message(self) -> object:
        silent_s = time.monotonic() - self._counts[-1][0] if self._counts else float("inf")
        return self._message if silent_s < SILENT_AFTER_S else None

    @property
    def rate_hz(self) -> float:
        """From sequence numbers, so that publications which were not looked at count too."""
        if self.message is None or len(self._counts) < 2:
            return 0.0
        (first_s, first, _), (last_s, last, _) = self._counts[0], self._counts[-1]
        return (last - first) / (last_s - first_s)

    def _count(self, received: Received) -> None:
        now_s = time.monotonic()
        if self._counts and self._counts[-1][2] != received.epoch:
            self._counts.clear()
        self._counts.append((now_s, received.sequence, received.epoch))
        while now_s - self._counts[0][0] > RATE_WINDOW_S:
            self._counts.popleft()
