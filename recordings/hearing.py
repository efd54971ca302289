"""Everything that is logged, as it comes over the bus."""

from collections.abc import Callable

from messaging.errors import CodecError
from messaging.session import Session
from messaging.topics import TOPICS
from recordings.backlog import Heard

SWEEP = 64


class Hearing:
    """Subscribes to each logged topic; `depth` publications of each may wait to be taken."""

    def __init__(self, session: Session, depth: int) -> None:
        self._rings = [(topic, session.every(topic, depth)) for topic in TOPICS if topic.logged]
        self._newest_ns = 0

    def take(self, now_ns: int, refuse: Callable[[CodecError], None]) -> list[Heard]:
        """What has come since the last time, by publish time, with log times (Unix ns) that increase.

        The number is bounded, so that one busy topic keeps nothing else waiting. What has no envelope is refused.
        """
        taken = []
        for topic, ring in self._rings:
            for _ in range(SWEEP):
                try:
                    received = ring.take()
                except CodecError as error:
                    refuse(error)
                    continue
                if received is None:
                    break
                taken.append((topic, received))
        taken.sort(key=lambda one: one[1].publish_time_ns)
        first_ns = max(now_ns, self._newest_ns + 1)
        heard = [Heard(topic, received, first_ns + place) for place, (topic, received) in enumerate(taken)]
        self._newest_ns = first_ns + len(heard)
        return heard
