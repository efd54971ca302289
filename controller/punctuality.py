"""How well cycles keep time, in words for the log: missed deadlines soon but not often, percentiles once a minute. Pure."""

import logging
from collections.abc import Iterator

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

    def told(self, timing: Timing, command: TendonCommand | None, now_s: float) -> Iterator[tuple[int, str]]:
        """One more cycle has passed: what is to be logged of it, with its level."""
        self._late_s.append(timing.lateness_s)
        if command is not None and command.capture_to_command_ns >= 0:
            self._age_s.append(command.capture_to_command_ns * 1e-9)
        missed = timing.overruns - self._warned_of
        if missed and now_s >= self._may_warn_at_s:
            self._warned_of, self._may_warn_at_s = timing.overruns, now_s + _WARN_AGAIN_S
            yield logging.WARNING, f"{missed} cycles were missed, {timing.overruns} since the start"
        if now_s >= self._summary_at_s:
            yield logging.INFO, self._summary(timing.overruns - self._before)
            self._summary_at_s, self._before = now_s + _SUMMARY_S, timing.overruns
            self._late_s.clear()
            self._age_s.clear()

    def _summary(self, missed: int) -> str:
        words = f"cycles {_percentiles(self._late_s)} late, {missed} missed"
        if self._age_s:
            words += f"; capture to command {_percentiles(self._age_s)} of {len(self._age_s)} shapes"
        return words


def _percentiles(values_s: list[float]) -> str:
    p50, p99, most = np.percentile(values_s, [50, 99, 100]) * 1e3
    return f"p50 {p50:.1f}, p99 {p99:.1f}, at most {most:.1f} ms"
