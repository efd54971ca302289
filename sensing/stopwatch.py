"""How long the stages of an estimate took, on a clock that is handed in."""

from collections.abc import Callable


class Stopwatch:
    """Seconds spent between laps, added up by name."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._since = clock()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        """The time since the last lap was spent on this."""
        now = self._clock()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._since
        self._since = now
