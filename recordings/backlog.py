"""What was heard and is not recorded yet: the rolling buffer, and what waits while a disk stalls. Pure."""

from collections import deque
from typing import NamedTuple

from messaging.session import Received
from messaging.topics import ASKED, LOG, TOPICS, Topic

OVERHEAD_BYTES = 500
"""What a publication takes in memory beside its payload, about."""
EVENTS = (ASKED, LOG)
"""Topics that tell what happened, not how things stand."""
SELDOM = frozenset(
    topic.key
    for topic in TOPICS
    if topic.logged and (topic.rate_hz is None or topic.rate_hz <= 1) and topic not in EVENTS
)
"""Topics whose newest message still holds long after it was said."""


class Heard(NamedTuple):
    """A publication, its line in the table of topics, and when it was heard (Unix ns)."""

    topic: Topic
    received: Received
    log_time_ns: int


class Backlog:
    """Publications in the order of hearing. Beyond `limit_bytes` the oldest are dropped.

    `newest` holds, of each topic that is said seldom, the newest publication among those that have left.
    """

    def __init__(self, limit_bytes: int) -> None:
        self._limit_bytes = limit_bytes
        self._heard: deque[Heard] = deque()
        self.size_bytes = 0
        self.dropped = 0
        self.newest: dict[str, Heard] = {}

    def append(self, heard: Heard) -> None:
        """Take in one more."""
        self._heard.append(heard)
        self.size_bytes += len(heard.received.payload) + OVERHEAD_BYTES
        while self.size_bytes > self._limit_bytes:
            self.pop()
            self.dropped += 1

    def pop(self) -> Heard:
        """Let the oldest go; raises IndexError when there is none."""
        heard = self._heard.popleft()
        self.size_bytes -= len(heard.received.payload) + OVERHEAD_BYTES
        if heard.topic.key in SELDOM:
            self.newest[heard.received.key] = heard
        return heard

    def forget(self, before_ns: int) -> None:
        """Let go of what was heard before this time."""
        while self._heard and self._heard[0].log_time_ns < before_ns:
            self.pop()

    @property
    def first_ns(self) -> int | None:
        """When the oldest was heard; None when there is none."""
        return self._heard[0].log_time_ns if self._heard else None
