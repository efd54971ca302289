"""Where the linear stage had the base when a frame was taken, from what the servos reported around that time."""

from collections import deque

import numpy as np

from messaging.control import TendonState

KEPT = 100
"""Reports; far more than a frame is old."""


class StageHeight:
    """A short history of insertions by Unix time."""

    def __init__(self, age_limit_s: float) -> None:
        self._age_limit_ns = int(age_limit_s * 1e9)
        self._history: deque[tuple[int, float]] = deque(maxlen=KEPT)

    def heard(self, state: TendonState) -> None:
        """Take note of a report; one that is older than the last (a clock set back) starts the history anew."""
        if self._history and state.time_ns < self._history[-1][0]:
            self._history.clear()
        self._history.append((state.time_ns, state.insertion_mm))

    def at(self, time_ns: int) -> tuple[float, bool]:
        """Insertion in mm at a Unix time, and whether reports near enough support it (else it is the last known, or 0)."""
        if not self._history:
            return 0.0, False
        start = self._history[0][0]
        times = np.array([when - start for when, _ in self._history], dtype=np.float64)
        heights = np.array([height for _, height in self._history])
        gap_ns = min(
            abs(time_ns - start - times[-1]), 0 if times[0] <= time_ns - start <= times[-1] else np.inf
        )
        return float(np.interp(time_ns - start, times, heights)), bool(gap_ns <= self._age_limit_ns)
