"""What keeps recorded messages from being taken for live ones: whoever says the same, or acts on it, must not be there."""

import time
from collections.abc import Callable, Mapping, Sequence
from threading import Event

from messaging.session import Presence
from messaging.topics import Topic
from nodal.errors import ReplayError
from nodal.replay.live.topics import moves_a_robot, speakers

CONTROLLER, RENDEZVOUS = "controller", "rendezvous"
REPLAY = "replay-"
"""Replays are told apart by the numbers of their processes."""
MEET_WITHIN_S = 5.0
SETTLE_S = 1.0
"""Word of every process comes this soon after that of the rendezvous."""
LOOK_S = 0.02


class Guard:
    """Knows which processes must not be alive on this bench while these topics are replayed by the process `own_name`."""

    def __init__(
        self, presence: Presence, bench: str, topics: Sequence[Topic], own_name: str, *, feed_controller: bool
    ) -> None:
        self._alive = presence.alive
        self._bench = bench
        self._speakers: Mapping[str, list[str]] = speakers(topics)
        self._own_name = own_name
        self._spare_controller = any(map(moves_a_robot, topics)) and not feed_controller

    def meet(self, endpoint: str, stop: Event) -> None:
        """Wait until word of every process must have come; raises ReplayError as `check` does, or without a rendezvous."""
        if not self._looking(lambda: RENDEZVOUS in self._alive(), MEET_WITHIN_S, stop):
            raise ReplayError(
                f"no rendezvous of bench {self._bench} answers at {endpoint}; start `nodal rendezvous`, "
                "or name another bench with --config"
            )
        self._looking(lambda: False, SETTLE_S, stop)

    def check(self) -> None:
        """Raise ReplayError naming the process that must not be alive; never waits."""
        for process in sorted(self._alive() - {self._own_name}):
            if keys := self._speakers.get(process):
                raise ReplayError(
                    f"{process} is alive on bench {self._bench} and says {', '.join(keys)} itself; "
                    "stop it, or choose other topics with --topics"
                )
            if process.startswith(REPLAY):
                raise ReplayError(f"another replay ({process}) is under way on bench {self._bench}")
            if process == CONTROLLER and self._spare_controller:
                raise ReplayError(
                    f"a controller is alive on bench {self._bench}, and its robot may move by recorded shapes; "
                    "leave shape out of --topics, or say --feed-controller if that is what you want"
                )

    def _looking(self, met: Callable[[], bool], within_s: float, stop: Event) -> bool:
        """Check again and again until the condition is met, or time is up; True when it is met, or to stop."""
        deadline_s = time.monotonic() + within_s
        while not (met() or stop.is_set()):
            self.check()
            if time.monotonic() > deadline_s:
                return False
            stop.wait(LOOK_S)
        return True
