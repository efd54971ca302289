"""What was said on each topic: how much, how steadily, and how often whoever says it began anew. Pure."""

from collections.abc import Mapping

from messaging import topics
from recordings.reader import Recorded, topic_of

ONE_VOICE = (topics.SHAPE, topics.CONTROLLER_STATE, topics.TRUTH)
"""Topics of which one process says one a step, by which its restarts are told."""


class TopicTraffic:
    """Counts one topic's publications, in order of recording. Times are Unix ns, as logged.

    Numbers that fall back begin a new life of the publisher.
    """

    def __init__(self, *, one_voice: bool) -> None:
        """`one_voice`: a single process says it, so that its numbers tell of losses and restarts."""
        self.messages = 0
        self.size_bytes = 0
        self.missing = 0
        """Numbers left out within a life."""
        self.first_ns = 0
        self.last_ns = 0
        self.largest_gap_ns = 0
        """Between two publications, restarts included."""
        self.largest_gap_at_ns = 0
        self.restarts_ns: list[int] = []
        self.unreadable = 0
        self.unreadable_example = ""
        self._one_voice = one_voice
        self._next = 0

    def hear(self, recorded: Recorded) -> None:
        """One publication."""
        now_ns = recorded.log_time_ns
        if not self.messages:
            self.first_ns = now_ns
        elif self._one_voice and recorded.sequence < self._next:
            self.restarts_ns.append(now_ns)
        elif self._one_voice:
            self.missing += recorded.sequence - self._next
        if self.messages and now_ns - self.last_ns > self.largest_gap_ns:
            self.largest_gap_ns, self.largest_gap_at_ns = now_ns - self.last_ns, self.last_ns
        self.messages += 1
        self.size_bytes += len(recorded.payload)
        self.last_ns = now_ns
        self._next = recorded.sequence + 1

    def refuse(self, problem: str) -> None:
        """One that was heard, and could not be read."""
        self.unreadable += 1
        self.unreadable_example = self.unreadable_example or problem

    @property
    def rate_hz(self) -> float | None:
        """Mean rate; None for fewer than two."""
        span_ns = self.last_ns - self.first_ns
        return (self.messages - 1) / span_ns * 1e9 if span_ns else None


def topic_traffic(traffic: dict[str, TopicTraffic], key: str) -> TopicTraffic:
    """The traffic of this topic, begun when it is heard for the first time."""
    if key not in traffic:
        topic = topic_of(key)
        traffic[key] = TopicTraffic(one_voice=topic is not None and topic.said_by != "all")
    return traffic[key]


def restarts(traffic: Mapping[str, TopicTraffic]) -> list[tuple[int, str]]:
    """When which process began anew while others went on, in order of time."""
    return sorted(
        (at_ns, topic.said_by)
        for topic in ONE_VOICE
        if topic.key in traffic
        for at_ns in traffic[topic.key].restarts_ns
    )
