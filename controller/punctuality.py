"""How well cycles keep time, in words for the log: missed deadlines soon but not often, percentiles once a minute. Pure."""

import numpy as np

from controller.account import Timing
from messaging.control import TendonCommand

_WARN_AGAIN_S = 5.0
_SUMMARY_S = 60.0


class Punctuality:
    """Hears of every cycle."""

    def __init__(self, now_s: float) -> None:
        """The first minute begins now."""
        self._summary_at_s = now_s + _SUMMARY_S
        self._may_warn_at_s = now_s
        self._warned_of = 0
        self._before = 0
        self._late_s: list[float] = []
        self._age_s: list[float] = []

    def note(self, timing: Timing, command: TendonCommand | None) -> None:
        """One cycle has passed."""
        self._late_s.append(timing.lateness_s)
        if command is not None and command.capture_to_command_ns >= 0:
            self._age_s.append(command.capture_to_command_ns * 1e-9)

    def warning(self, overruns: int, now_s: float) -> str:
        """How many deadlines were missed since the last warning; nothing when there is none, or it was just now."""
        fresh = overruns - self._warned_of
        if not fresh or now_s < self._may_warn_at_s:
            return ""
        self._warned_of, self._may_warn_at_s = overruns, now_s + _WARN_AGAIN_S
        return f"{fresh} cycles were missed, {overruns} since the start"

    def summary(self, overruns: int, now_s: float) -> str:
        """The last minute, once it is over; nothing before."""
        if now_s < self._summary_at_s:
            return ""
        words = [f"cycles {_percentiles(self._late_s)} late, {overruns - self._before} missed"]
        if self._age_s:
            words.append(f"capture to command {_percentiles(self._age_s)} of {len(self._age_s)} shapes")
        self._summary_at_s, self._before = now_s + _SUMMARY_S, overruns
        self._late_s.clear()
        self._age_s.clear()
        return "; ".join(words)


def _percentiles(values_s: list[float]) -> str:
    p50, p99, most = np.percentile(values_s, [50, 99, 100]) * 1e3
    return f"p50 {p50:.1f}, p99 {p99:.1f}, at most {most:.1f} ms"
