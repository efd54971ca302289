"""Time kept and missed: a grid of deadlines, commands that never make up for a stall at once, and words for the log."""

import logging
import time

import pytest

from controller import pace as paces
from controller.account import Timing
from controller.pace import Pace
from controller.punctuality import Punctuality
from messaging.control import TendonCommand


@pytest.fixture
def clock(monkeypatch):
    """A monotonic clock that only sleeping and the test move on."""

    class Clock:
        now_s = 1000.0

        def monotonic(self):
            return self.now_s

        def sleep(self, seconds):
            self.now_s += seconds

    clock = Clock()
    monkeypatch.setattr(paces, "time", clock)
    return clock


def test_a_stall_is_counted_and_not_made_up_for_at_once(clock):
    pace = Pace(200)
    beats = [pace.wait() for _ in range(3)]
    clock.now_s += 0.0501
    late = pace.wait()
    following = pace.wait()

    assert [beat.overruns for beat in beats] == [0, 0, 0]
    assert (late.overruns, late.cycle) == (9, 13)
    assert late.dt_s == pytest.approx(4 * 0.005), "no more than four periods, however long it was"
    assert late.lateness_s == pytest.approx(0.0001, abs=1e-9)
    assert (following.overruns, following.dt_s) == (9, 0.005)
    assert following.now_s == pytest.approx(1000.0 + 14 * 0.005), (
        "deadlines stay on the grid of the first one"
    )


def timing(lateness_s=0.0001, overruns=0):
    return Timing(written_s=0.0, time_ns=0, lateness_s=lateness_s, busy_s=0.0, overruns=overruns)


def command(age_ns):
    return TendonCommand(
        time_ns=0, displacement_mm=[0.0], insertion_mm=0.0, shape_sequence=1, capture_to_command_ns=age_ns
    )


def test_missed_cycles_are_told_at_once_and_then_rarely():
    punctuality = Punctuality(0.0)

    def told(overruns, now_s):
        return list(punctuality.told(timing(overruns=overruns), None, now_s))

    assert told(0, 1.0) == []
    assert told(2, 1.1) == [(logging.WARNING, "2 cycles were missed, 2 since the start")]
    assert [told(count, 1.1 + count / 10) for count in range(3, 40)] == [[]] * 37
    assert told(40, 6.2) == [(logging.WARNING, "38 cycles were missed, 40 since the start")]
    assert told(40, 20.0) == []


def test_a_minute_is_summed_up_once():
    punctuality = Punctuality(0.0)

    def told(now_s, lateness_s, overruns=3, age_ns=-1):
        return [
            line
            for level, line in punctuality.told(timing(lateness_s, overruns), command(age_ns), now_s)
            if level == logging.INFO
        ]

    for cycle in range(100):
        assert told(cycle * 0.5, cycle * 1e-5, age_ns=20_000_000 if cycle % 10 == 0 else -1) == []
    (summary,) = told(60.0, 0.0)
    cycles, commands = summary.split("; ")
    assert cycles == "cycles p50 0.5, p99 1.0, at most 1.0 ms late, 3 missed"
    assert commands == "capture to command p50 20.0, p99 20.0, at most 20.0 ms of 10 shapes"
    assert told(90.0, 0.002) == []
    assert told(120.0, 0.002, overruns=5) == ["cycles p50 2.0, p99 2.0, at most 2.0 ms late, 2 missed"]


def test_real_sleep_wakes_at_the_deadline_or_later():
    start_s = time.monotonic()
    pace = Pace(200)
    for number in range(1, 6):
        beat = pace.wait()
        assert beat.now_s >= start_s + number * 0.005
