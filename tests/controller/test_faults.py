"""Every fault of the drive, the shapes, the law, the loop and the operator: caused, named, in numbers, and safe in one cycle."""

import dataclasses
import inspect
import re
from typing import Any

import numpy as np
import pytest

from controller import faults
from controller.errors import FaultError
from controller.faults import FAULTS
from controller.law import Law
from controller.regions import HalfSpace, Sphere
from controller.settings import ControllerSettings, OperatorSettings, SensingSettings
from messaging.control import ControllerState, FaultMessage, Reply

PERIOD_S = 0.005


def first_fault(moments):
    """The first moment in fault."""
    return next(moment for moment in moments if moment.state.mode == "fault")


def heat(bench):
    bench.servos.temperature_c = 71.0


def starve(bench):
    bench.servos.voltage_v = 8.5


def overcharge(bench):
    bench.servos.voltage_v = 17.0


def overload(bench):
    bench.servos.current_ma = np.array([0.0, 0.0, -1234.0, 0.0, 0.0])


def run_away(bench):
    bench.servos.position_mm = bench.servos.position_mm + 9.0 * np.eye(5)[1]
    bench.servos.jammed = True


def lag(bench):
    bench.servos.position_mm = bench.state.command_mm + 3.5 * np.eye(5)[2]
    bench.servos.jammed = True


def stall(bench):
    bench.now_s += 0.6


TROUBLES = {
    heat: ("too_hot", 71.0, 70.0, "C", 0.0),
    starve: ("supply_voltage", 8.5, 9.0, "V", 0.5),
    overcharge: ("supply_voltage", 17.0, 16.0, "V", 0.5),
    overload: ("excess_current", 1234.0, 800.0, "mA", 0.1),
    run_away: ("travel", 9.0, 5.0, "mm", 0.0),
    lag: ("not_following", 3.5, 3.0, "mm", 0.5),
    stall: ("loop_stalled", 0.6, 0.5, "s", 0.0),
}


@pytest.mark.parametrize("trouble", TROUBLES, ids=lambda trouble: trouble.__name__)
def test_trouble_is_a_fault_with_its_value_and_its_limit_once_its_grace_is_over(homed, trouble):
    code, value, limit, unit, grace_s = TROUBLES[trouble]
    trouble(homed)
    began_s = homed.now_s
    moments, _ = homed.run(grace_s + 0.05)
    fault = first_fault(moments)
    assert grace_s - 1e-6 <= fault.now_s - began_s <= grace_s + 2 * PERIOD_S
    found = fault.state.supervision.fault
    assert (found.code, found.limit, found.unit) == (code, limit, unit)
    assert found.value == pytest.approx(value, abs=0.05)
    assert f"{limit:g}" in fault.outputs.reason
    assert fault.outputs.release
    assert fault.outputs.command_mm is None
    assert not homed.servos.torque


def test_a_slow_servo_that_comes_nearer_is_no_fault(homed):
    lag(homed)
    said = homed.servos.state
    nearing = np.array([0.0, 0.0, -0.6, 0.0])
    homed.servos.state = lambda: dataclasses.replace(said(), displacement_mm_s=nearing)
    homed.run(1.0)
    assert homed.state.mode == "ready"
    homed.servos.state = lambda: dataclasses.replace(said(), displacement_mm_s=-nearing)
    homed.run(1.0)
    assert homed.state.supervision.fault.code == "not_following"


@pytest.mark.parametrize("trouble", [starve, overload, lag], ids=lambda trouble: trouble.__name__)
def test_what_is_over_within_its_grace_is_no_fault(homed, trouble):
    well = dataclasses.replace(homed.servos)
    for _ in range(4):
        trouble(homed)
        homed.run(TROUBLES[trouble][-1] * 0.8)
        homed.servos = dataclasses.replace(well, zero_mm=homed.servos.zero_mm)
        homed.run(2 * PERIOD_S)
    assert homed.state.mode == "ready", homed.state.supervision


def test_the_same_trouble_in_idle_is_no_fault(paper_bench):
    for trouble in TROUBLES:
        trouble(paper_bench)
        paper_bench.run(0.6)
    assert paper_bench.state.mode == "idle"


@pytest.mark.parametrize("code", ["drive_lost", "watchdog_expired", "servo_restarted", "servo_alarm"])
def test_why_the_drive_is_gone_is_the_fault_s_own_kind_in_the_driver_s_words(homed, code):
    homed.drive_absent, homed.drive_fault = "servo 3 says something", code
    moments, _ = homed.run(PERIOD_S)
    assert moments[0].state.supervision.fault.code == code
    assert moments[0].outputs.reason == "servo 3 says something"


@pytest.mark.parametrize(
    ("region", "words"),
    [
        (Sphere(name="lamp", centre_mm=(0.0, 0.0, 81.0), radius_mm=6.0), "5.* mm inside the forbidden region lamp"),
        (HalfSpace(name="wall", point_mm=(0.0, 0.0, 79.0), normal=(0.0, 0.0, -1.0)), "inside the forbidden region wall"),
    ],
)  # fmt: skip
def test_a_robot_seen_in_a_forbidden_region_is_let_go_and_stays_so(stand_ins, region, words):
    settings = ControllerSettings(forbidden=(region,))
    bench = stand_ins["VirtualBench"](
        stand_ins["PaperRobot"](settings.kinematics(stand_ins["ROBOT"])), settings
    )
    bench.run(0.2)
    assert bench.state.mode == "idle"
    assert bench.do("home").accepted
    fault = first_fault(bench.run(0.3)[0])
    assert fault.state.supervision.fault.code == "region_entered"
    assert fault.state.supervision.fault.value > 0
    assert re.search(words, fault.outputs.reason)
    assert fault.outputs.release
    assert bench.do("home").accepted
    assert first_fault(bench.run(0.3)[0]).outputs.release


def test_lost_shapes_say_for_how_long(tracking):
    tracking.camera = lambda _: None
    fault = first_fault(tracking.run(1.5)[0]).state.supervision.fault
    assert (fault.code, fault.limit, fault.unit) == ("sensing_lost", 1.0, "s")
    assert fault.value == pytest.approx(1.0, abs=2 * PERIOD_S)


class Broken(Law[None]):
    """A law that raises."""

    lead_s = 0.0

    def start(self, beginning):
        raise ZeroDivisionError("no way")

    def step(self, state: Any, inputs):
        raise KeyError("tendon")


def test_a_law_that_raises_is_a_fault_and_ends_nothing_else(tracking, homed, stand_ins):
    for bench, words in ((tracking, "KeyError: 'tendon' (test_faults.py:"), (homed, "no way")):
        bench.loop._motion._law = Broken()
        if bench is homed:
            bench.run(PERIOD_S, stand_ins["circle"]())
            bench.do("arm")
        bench.run(PERIOD_S)
        assert bench.state.supervision.fault.code == "law_failed"
        assert words in bench.state.supervision.reason
        assert not bench.servos.torque


def test_an_operator_who_is_gone_makes_a_hold_and_then_a_fault(stand_ins):
    settings = ControllerSettings(operator=OperatorSettings(heartbeat_s=0.5, hold_s=1.0))
    bench = stand_ins["VirtualBench"](
        stand_ins["PaperRobot"](settings.kinematics(stand_ins["ROBOT"])), settings
    )
    bench.run(0.2)
    assert "no operator's heartbeat within 0.5 s" in bench.do("home").reason
    bench.heartbeat = True
    bench.home()
    bench.run(PERIOD_S, stand_ins["circle"]())
    bench.do("arm", 1.0)
    assert bench.state.mode == "tracking"
    bench.heartbeat = False
    moments, _ = bench.run(2.0)
    held = next(moment for moment in moments if moment.state.mode == "hold")
    fault = first_fault(moments)
    assert held.now_s - moments[0].now_s == pytest.approx(0.5, abs=0.01)
    assert fault.now_s - moments[0].now_s == pytest.approx(1.5, abs=0.01)
    assert fault.state.supervision.fault.code == "operator_lost"
    assert "no operator" in held.outputs.reason
    bench.heartbeat = True
    bench.run(1.0)
    assert bench.state.mode == "fault"


@pytest.fixture
def watched(stand_ins):
    """A bench that needs an operator's heartbeat, and has one."""
    settings = ControllerSettings(operator=OperatorSettings(heartbeat_s=0.5, hold_s=1.0))
    robot = stand_ins["PaperRobot"](settings.kinematics(stand_ins["ROBOT"]))
    bench = stand_ins["VirtualBench"](robot, settings)
    bench.heartbeat = True
    bench.run(0.2)
    return bench


def leave_homing_early(bench):
    bench.do("home", 0.5)
    return bench.state.search is not None


def leave_homing_late(bench):
    bench.do("home")
    while bench.state.search is not None:
        bench.cycle(())
    return bench.state.mode == "homing"


def leave_a_jog(bench):
    return bench.jog("2", 4.0, 0.3).state == "unhomed"


def leave_a_jog_of_a_homed_robot(bench):
    bench.home()
    return bench.jog("2", 4.0, 0.3).state == "hold"


@pytest.mark.parametrize(
    ("leave", "mode"),
    [
        (leave_homing_early, "unhomed"),
        (leave_homing_late, "unhomed"),
        (leave_a_jog, "unhomed"),
        (leave_a_jog_of_a_homed_robot, "hold"),
    ],
)
def test_nothing_goes_on_moving_without_its_operator(watched, leave, mode):
    assert leave(watched)
    watched.heartbeat = False
    moments, _ = watched.run(1.6)
    sent = {m.now_s - moments[0].now_s: m.outputs.command_mm for m in moments if m.state.mode == mode}
    still = np.array([command_mm for after_s, command_mm in sent.items() if after_s > 0.51])
    assert len(still) > 100
    assert (np.ptp(still, axis=0) == 0).all()
    held = [moment.outputs.reason for moment in moments if moment.state.mode == mode]
    assert held[-1] == "no operator's heartbeat for more than 0.5 s"
    assert first_fault(moments).state.supervision.fault.code == "operator_lost"


def test_an_operator_who_comes_back_sets_nothing_in_motion(watched):
    watched.jog("2", 4.0, 0.3)
    watched.heartbeat = False
    watched.run(0.6)
    watched.heartbeat = True
    moments, _ = watched.run(1.0)
    assert {m.state.mode for m in moments} == {"unhomed"}
    assert (np.ptp([m.outputs.command_mm for m in moments], axis=0) == 0).all()
    assert watched.do("home").accepted


def test_a_fault_and_home_in_one_cycle_end_in_the_fault(homed):
    homed.servos.hardware_error = 0x20
    reply = homed.do("home")
    assert not reply.accepted
    assert (reply.state, reply.fault) == ("fault", "servo_alarm")
    assert reply.advice == faults.ServoAlarmError.advice
    assert not homed.servos.torque


def test_every_fault_has_a_code_of_its_own_and_advice():
    kinds = {kind for _, kind in inspect.getmembers(faults, inspect.isclass) if issubclass(kind, FaultError)}
    assert set(FAULTS.values()) == kinds - {FaultError}
    for code, kind in FAULTS.items():
        assert kind.code == code
        assert len(kind.advice) > 20
        assert kind.__doc__


def test_replies_and_states_tell_of_a_fault_alike():
    assert issubclass(Reply, FaultMessage)
    assert issubclass(ControllerState, FaultMessage)


def test_a_hold_must_come_before_its_fault():
    with pytest.raises(ValueError, match=r"timeout_s 0.5 must be less than hold_at_most_s 0.4"):
        SensingSettings(timeout_s=0.5, hold_at_most_s=0.4)
    with pytest.raises(ValueError, match=r"heartbeat_s 0.1 must be 0, or at least 0.3"):
        OperatorSettings(heartbeat_s=0.1)
