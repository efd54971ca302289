"""Every pair of mode and event, and the rule at the head of controller/supervisor.py."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.faults import DriveLostError, TravelError
from controller.supervisor import Event, Fault, Happening, Mode, Supervision, next_state
from messaging.control import Action, State

EXPECTED = """
               idle     homing  ready     tracking  hold      waiting   relaxing  unhomed  fault
home           homing   .       homing    .         homing    homing    homing    homing   homing
arm            .        .       tracking  tracking  tracking  tracking  tracking  .        .
hold           .        .       hold      hold      hold      hold      hold      unhomed  .
pause          .        .       .         tracking  .         waiting   .         .        .
resume         .        .       .         tracking  .         waiting   .         .        .
abort          .        .       ready     hold      hold      hold      .         .        .
jog            unhomed  .       hold      .         hold      .         .         unhomed  .
relax          idle     idle    relaxing  relaxing  relaxing  relaxing  relaxing  idle     idle
stop           idle     idle    idle      idle      idle      idle      idle      idle     fault
homed          .        ready   .         .         .         .         .         .        .
relaxed        .        .       .         .         .         .         idle      .        .
sensing_lost   .        .       .         waiting   .         .         .         .        .
sensing_good   .        .       .         .         .         tracking  .         .        .
operator_lost  .        unhomed .         hold      hold      hold      .         unhomed  .
"""
HEADER, *ROWS = EXPECTED.strip().splitlines()
TABLE = {
    (Mode(mode), Event(row.split()[0].replace("_", " "))): following
    for row in ROWS
    for mode, following in zip(HEADER.split(), row.split()[1:], strict=True)
}
HOMED = {Mode.READY, Mode.TRACKING, Mode.HOLD, Mode.WAITING, Mode.RELAXING}
HOT = TravelError("too far", value=6.0, limit=5.0, unit="mm")


def happening(event):
    return Happening(event=event, reason=f"because of {event}")


def in_mode(mode):
    return Supervision.failed(HOT, 1.0) if mode is Mode.FAULT else Supervision(mode=mode, since_s=1.0)


def test_the_table_of_this_test_is_complete():
    assert set(TABLE) == set(itertools.product(Mode, Event))


@pytest.mark.parametrize(("mode", "event"), TABLE, ids=lambda value: value.value.replace(" ", "_"))
def test_every_pair(mode, event):
    before = in_mode(mode)
    after, (allowed,) = next_state(before, [happening(event)], [], 2.0)
    if TABLE[mode, event] in (".", mode.value) and (event is not Event.OPERATOR_LOST or not allowed):
        assert after == before
        assert allowed == (TABLE[mode, event] != ".")
    else:
        assert after == Supervision(mode=Mode(TABLE[mode, event]), reason=f"because of {event}", since_s=2.0)
        assert allowed


@pytest.mark.parametrize("mode", Mode)
def test_a_fault_takes_torque_wherever_there_is_some(mode):
    before = in_mode(mode)
    after, _ = next_state(before, [], [HOT, DriveLostError("second")], 2.0)
    if mode.torque:
        fault = Fault(code="travel", value=6.0, limit=5.0, unit="mm")
        assert after == Supervision(mode=Mode.FAULT, reason="too far", since_s=2.0, fault=fault)
        assert after.told["advice"] == TravelError.advice
    else:
        assert after == before


@pytest.mark.parametrize(("mode", "event"), TABLE, ids=lambda value: value.value.replace(" ", "_"))
def test_a_fault_makes_everything_beside_it_void(mode, event):
    after, (allowed,) = next_state(in_mode(mode), [happening(event)], [HOT], 2.0)
    if mode.torque:
        assert after.mode is Mode.FAULT
        assert allowed == (event is Event.STOP)


events = st.lists(st.sampled_from(Event), max_size=4)
faults = st.sampled_from([[], [], [DriveLostError("lost")]])
cycles = st.lists(st.tuples(events, faults), max_size=30)


def run(cycles):
    """Each cycle: before, what happened, whether something failed, after."""
    current = Supervision()
    for happened, fault in cycles:
        following, _ = next_state(current, [happening(event) for event in happened], fault, 0.0)
        yield current, set(happened), bool(fault), following
        current = following


@given(st.sampled_from(Mode), events, events, faults)
def test_stop_wins_whatever_happens_beside_it(mode, earlier, later, fault):
    happenings = [happening(event) for event in (*earlier, Event.STOP, *later)]
    after, allowed = next_state(in_mode(mode), happenings, fault, 2.0)
    assert not after.mode.torque
    assert all(allowed[index] == (h.event is Event.STOP) for index, h in enumerate(happenings))


@given(cycles)
def test_torque_comes_on_by_home_and_jog_only_and_faults_are_left_by_the_operator_only(cycles):
    for before, happened, _, after in run(cycles):
        if after.mode.torque and not before.mode.torque:
            assert happened & {Event.HOME, Event.JOG}
        if before.mode is Mode.FAULT and after.mode is not Mode.FAULT:
            assert happened & {Event.HOME, Event.RELAX}
            assert Event.STOP not in happened


@given(cycles)
def test_no_torque_outlives_a_fault_and_none_without_numbers_or_words_is_left(cycles):
    for before, _, failed, after in run(cycles):
        if failed and before.mode.torque:
            assert after.mode is Mode.FAULT
        assert (after.fault is not None) == (after.mode is Mode.FAULT)
        assert after.reason


@given(cycles)
def test_a_robot_is_homed_only_by_homing(cycles):
    for before, happened, _, after in run(cycles):
        if after.mode in HOMED and before.mode not in HOMED:
            assert before.mode is Mode.HOMING or Event.HOME in happened
            assert Event.HOMED in happened


@given(cycles)
def test_nothing_but_an_operator_sets_a_homed_robot_in_motion(cycles):
    """Waiting goes on by itself, and only to where it came from."""
    for before, happened, _, after in run(cycles):
        if after.mode is Mode.TRACKING and before.mode not in (Mode.TRACKING, Mode.WAITING):
            assert Event.ARM in happened


def test_a_start_is_in_idle_and_says_the_bench_s_own_words():
    assert Supervision().mode is Mode.IDLE
    assert {mode.state for mode in Mode} == set(State)
    noticed = {Event.HOMED, Event.RELAXED, Event.SENSING_LOST, Event.SENSING_GOOD, Event.OPERATOR_LOST}
    actions = {Event(action.value) for action in Action if action is not Action.STATUS}
    assert actions == set(Event) - noticed
