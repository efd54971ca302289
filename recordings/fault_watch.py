"""Notices when the controller's state becomes `fault`, and decodes as little as it can for that. Pure."""

from messaging.control import ControllerState, State
from messaging.errors import CodecError
from messaging.message import parse
from messaging.topics import CONTROLLER_STATE
from recordings.backlog import Heard

FAULT = State.FAULT.encode()


class FaultWatch:
    """Hears everything that is heard. A fault that was there from the beginning is none that begins."""

    def __init__(self) -> None:
        self._fault: bool | None = None

    def begins(self, heard: Heard) -> str | None:
        """The controller's reason when this publication tells of a new fault; None otherwise."""
        if heard.topic is not CONTROLLER_STATE:
            return None
        before, reason = self._fault, None
        self._fault = False
        # most states are without the word, and need not be decoded
        if FAULT in heard.received.payload:
            try:
                state = parse(ControllerState.protobuf, heard.received.payload)
            except CodecError:
                return None
            self._fault = state.state == State.FAULT
            reason = state.reason
        return reason if self._fault and before is False else None
