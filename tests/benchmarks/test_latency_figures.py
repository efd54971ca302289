"""What the latency benchmark makes of a recording's messages."""

import dataclasses
import io

import numpy as np
import pytest

from benchmarks.latency.figures import figures_from
from messaging.control import ControllerState, State, TendonCommand

CYCLE = ControllerState(
    time_ns=0,
    state=State.TRACKING,
    reason="",
    target_name="",
    node_names=(),
    desired_mm=np.zeros((0, 3)),
    measured_mm=np.zeros((0, 3)),
    tracking_error_mm=0.0,
    shape_sequence=0,
    shape_age_s=0.0,
    lateness_s=0.0,
    busy_s=0.002,
    overruns=7,
    now_s=0.0,
    dt_s=0.005,
    sighted_capture_ns=0,
    sighted_age_s=0.0,
    drive_absence="",
    commanded=True,
)


def command(age_ns):
    return TendonCommand(
        time_ns=0, displacement_mm=[], insertion_mm=0.0, shape_sequence=1, capture_to_command_ns=age_ns
    )


@pytest.fixture
def figures():
    cycles = [
        dataclasses.replace(CYCLE, lateness_s=0.0001),
        # the cycle before this one took 6 of its 5 ms, so that this one had no rest
        dataclasses.replace(CYCLE, lateness_s=0.0011, busy_s=0.006),
        dataclasses.replace(CYCLE, lateness_s=0.0002, overruns=9, state=State.HOLD),
        dataclasses.replace(CYCLE, lateness_s=0.0003, overruns=9),
    ]
    return figures_from(
        [command(30_000_000), command(-1), command(14_000_000)], cycles, [], 0.02, {"control": 0.15}
    )


def test_only_first_commands_tell_an_age(figures):
    assert figures.capture_to_command_ms.tolist() == [30.0, 14.0]


def test_cycles_that_had_no_rest_are_told_apart(figures):
    assert figures.lateness_ms[figures.rested].tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert figures.overruns == 2
    assert figures.tracked == 0.75


def test_yardsticks_say_whether_they_are_met(figures):
    out = io.StringIO()
    dataclasses.replace(figures, sensing_ms=np.array([12.0])).show(out)
    lines = out.getvalue().splitlines()

    assert [line.split()[-1] for line in lines[:4]] == ["MISSED", "met", "MISSED", "met"]
    assert lines[-1] == "of one core: control 15.0 %"
