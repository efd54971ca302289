"""Deadlines at a fixed rate. They lie on a grid that begins with the first and is never shifted; missed ones are counted."""

import dataclasses
import time

MOST_PERIODS = 4
"""How many missed periods a command may make up for at once."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Beat:
    """One wake-up: when it was on the monotonic clock, how late, and how much time commands may use."""

    cycle: int
    now_s: float
    lateness_s: float
    dt_s: float
    overruns: int
    """Deadlines missed since the start."""


class Pace:
    """Wakes its caller at `rate_hz`."""

    def __init__(self, rate_hz: float) -> None:
        """The first deadline is one period from now."""
        self.period_s = 1 / rate_hz
        self._start_s = time.monotonic()
        self._count = 0
        self._overruns = 0

    def wait(self) -> Beat:
        """Sleep until the next deadline that is not entirely missed."""
        due = (time.monotonic() - self._start_s) / self.period_s
        missed = max(int(due) - self._count - 1, 0)
        self._count += missed + 1
        self._overruns += missed
        deadline_s = self._start_s + self._count * self.period_s
        if (slack_s := deadline_s - time.monotonic()) > 0:
            time.sleep(slack_s)
        now_s = time.monotonic()
        return Beat(
            cycle=self._count,
            now_s=now_s,
            lateness_s=max(now_s - deadline_s, 0.0),
            dt_s=min(missed + 1, MOST_PERIODS) * self.period_s,
            overruns=self._overruns,
        )
