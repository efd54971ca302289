"""The edge to the tendon drive and the pace of the loop."""

import dataclasses
import time

import numpy as np
import pytest

from controller.cycle import Outputs
from controller.drive import Drive
from controller.pace import Pace
from drivers.actuators import ActuatorError, ServoAlarmError, ServoRestartedError, WatchdogExpiredError

NOTHING = Outputs(
    tendons=4,
    release=False,
    engage=False,
    zero_mm=None,
    command_mm=None,
    replies=(),
    accepted=None,
    reason="",
)
COMMAND = np.array([1.0, 2.0, 3.0, 4.0, 5.0])


class Scripted:
    """Actuators that write down what is asked of them, and fail where `broken` says so."""

    def __init__(self):
        self.calls, self.broken, self.error = [], set(), ActuatorError

    def _call(self, name, *arguments):
        self.calls.append((name, *arguments))
        if name in self.broken:
            raise self.error(f"{name} failed")

    def open(self):
        self._call("open")

    def close(self):
        self._call("close")

    def read(self):
        self._call("read")
        return "reading"

    def write(self, displacement_mm, insertion_mm):
        self._call("write", displacement_mm.tolist(), insertion_mm)

    def set_zero(self, displacement_mm, insertion_mm):
        self._call("set_zero", displacement_mm.tolist(), insertion_mm)

    def enable(self):
        self._call("enable")

    def disable(self):
        self._call("disable")


@pytest.fixture
def actuators():
    return Scripted()


@pytest.fixture
def drive(actuators):
    drive = Drive(actuators)
    assert drive.read(10.0) == "reading"
    actuators.calls.clear()
    return drive


def test_what_was_decided_is_done_in_order(drive, actuators):
    everything = dataclasses.replace(NOTHING, engage=True, zero_mm=0 * COMMAND, command_mm=COMMAND)
    assert drive.act(everything, 10.0)
    zeros = [0.0] * 4
    assert actuators.calls == [("enable",), ("set_zero", zeros, 0.0), ("write", [1.0, 2.0, 3.0, 4.0], 5.0)]
    actuators.calls.clear()
    assert not drive.act(dataclasses.replace(NOTHING, release=True), 10.0)
    assert actuators.calls == [("disable",)]


def test_a_robot_without_a_stage_has_no_insertion(drive, actuators):
    drive.act(dataclasses.replace(NOTHING, tendons=5, command_mm=COMMAND), 10.0)
    assert actuators.calls == [("write", COMMAND.tolist(), 0.0)]


@pytest.mark.parametrize(
    ("error", "fault"),
    [
        (ActuatorError, "drive_lost"),
        (WatchdogExpiredError, "watchdog_expired"),
        (ServoRestartedError, "servo_restarted"),
        (ServoAlarmError, "servo_alarm"),
    ],
)
def test_what_the_driver_raised_is_told_by_its_kind_until_a_reading_comes(drive, actuators, error, fault):
    actuators.broken, actuators.error = {"read"}, error
    assert drive.read(10.0) is None
    assert (drive.absence, drive.absence_fault) == ("read failed", fault)
    actuators.broken = set()
    assert drive.read(11.1) == "reading"
    assert (drive.absence, drive.absence_fault) == ("", "")


@pytest.mark.parametrize("broken", ["read", "write", "enable", "set_zero"])
def test_after_trouble_the_drive_is_closed_and_sought_again_after_a_second(drive, actuators, broken):
    actuators.broken = {broken}
    drive.read(10.0)
    drive.act(dataclasses.replace(NOTHING, engage=True, zero_mm=COMMAND, command_mm=COMMAND), 10.0)
    assert actuators.calls[-1] == ("close",)
    assert drive.absence == f"{broken} failed"
    actuators.broken = set()
    assert drive.read(10.9) is None
    assert not drive.act(dataclasses.replace(NOTHING, command_mm=COMMAND), 10.9)
    assert actuators.calls[-1] == ("close",)
    assert drive.read(11.1) == "reading"
    assert drive.absence == ""
    assert ("enable",) not in actuators.calls[actuators.calls.index(("close",)) :]


def test_a_missing_drive_is_named_and_sought_once_a_second(actuators):
    actuators.broken = {"open"}
    drive = Drive(actuators)
    assert [drive.read(10.0 + n * 0.1) for n in range(30)] == [None] * 30
    assert drive.absence == "open failed"
    assert actuators.calls == [("open",)] * 3


def test_closing_a_drive_that_does_not_answer_raises_nothing(drive, actuators):
    actuators.broken = {"close"}
    drive.close()
    assert actuators.calls == [("close",)]


def test_deadlines_lie_on_one_grid_and_missed_ones_are_counted():
    pace = Pace(200.0)
    beats = [pace.wait() for _ in range(5)]
    time.sleep(0.053)
    late = pace.wait()
    grid = [(beat.now_s - beat.lateness_s - pace._start_s) / pace.period_s for beat in (*beats, late)]
    np.testing.assert_allclose(grid, np.round(grid), atol=1e-6)
    assert late.overruns - beats[-1].overruns >= 9
    assert late.cycle - beats[-1].cycle == late.overruns - beats[-1].overruns + 1
    assert beats[0].dt_s <= late.dt_s == pytest.approx(4 * pace.period_s)
