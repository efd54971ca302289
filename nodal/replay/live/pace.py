"""The moments at which publications are due, and how late they were."""

import time
from bisect import bisect_left
from collections import Counter
from itertools import accumulate
from threading import Event

LEAD_S = 0.05
LOOK_S = 0.05
"""Nothing waits longer than this without looking whether it should end."""
STEP_MS = 0.05


class Lateness:
    """Counts in steps of 0.05 ms, so that a replay that goes on for ever needs no more memory."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def add(self, late_s: float) -> None:
        """One more publication that was this late."""
        self._counts[round(1e3 * late_s / STEP_MS)] += 1

    def quantile_ms(self, share: float) -> float:
        """This share of the publications were no later; 0 when there are none."""
        steps = sorted(self._counts)
        totals = list(accumulate(self._counts[step] for step in steps))
        return STEP_MS * steps[bisect_left(totals, share * totals[-1])] if totals else 0.0


class Pace:
    """Deadlines that all hang on the first one, never on when the last publication went out; the first is a moment from now."""

    def __init__(self, speed: float, stop: Event) -> None:
        self._speed = speed
        self._stop = stop
        self._start_s = time.monotonic() + LEAD_S
        self.lateness = Lateness()

    def reached(self, due_ns: int) -> bool:
        """Wait a while at most for what is due this long after the first; True, and counted, once it is."""
        due_s = self._start_s + due_ns / 1e9 / self._speed
        if (slack_s := due_s - time.monotonic()) > 0:
            self._stop.wait(min(slack_s, LOOK_S))
        if (late_s := time.monotonic() - due_s) < 0:
            return False
        self.lateness.add(late_s)
        return True
