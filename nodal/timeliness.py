"""How old pictures are when the servos are told what follows from them, as the controller says it."""

import time
from collections import deque

import numpy as np

from messaging import topics
from messaging.control import TendonCommand
from messaging.session import Session

KEPT = 90
"""Shapes that percentiles are made of: three seconds of a camera at 30 Hz."""
WAITING_AT_MOST = 512


class Timeliness:
    """Hears the controller's commands. Call `take` often."""

    def __init__(self, session: Session) -> None:
        self._commands = session.every(topics.TENDON_COMMAND, WAITING_AT_MOST)
        self._ages_ms: deque[float] = deque(maxlen=KEPT)

    def take(self) -> None:
        """Hear what is new; never waits."""
        while (received := self._commands.take()) is not None:
            command = TendonCommand.from_bytes(received.payload)
            if command.capture_to_command_ns >= 0:
                self._ages_ms.append(command.capture_to_command_ns / 1e6)

    @property
    def words(self) -> str:
        """The last few seconds; nothing while there was no command that a new shape led to."""
        if not self._ages_ms:
            return ""
        p50, p99 = np.percentile(list(self._ages_ms), [50, 99])
        return f"p50 {p50:.0f} ms, p99 {p99:.0f} ms from capture to command"


def heard_within(session: Session, seconds: float) -> str:
    """Listen for so long; the words for what was heard."""
    timeliness = Timeliness(session)
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        time.sleep(0.05)
        timeliness.take()
    return timeliness.words
