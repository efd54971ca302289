"""Every pair of mode and event, and the rule at the head of controller/supervisor.py."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.errors import DriveLostError, TravelError
from controller.supervisor import Event, Happening, Mode, Supervision, next_state
from messaging.control import Action, State

EXPECTED = """
               idle      homing    ready     tracking  hold      waiting   relaxing  fault
home           homing    .         homing    .         homing    homing    homing    homing
arm            .         .         tracking  tracking  tracking  tracking  tracking  .
hold           .         .         hold      hold      hold      hold      hold      .
relax          idle      idle      relaxing  relaxing  relaxing  relaxing  relaxing  idle
stop           idle      idle      idle      idle      idle      idle      idle      fault
homed          .         ready     .         .         .         .         .         .
relaxed        .         .         .         .         .         .         idle      .
sensing_lost   .         .         .         waiting   .         .         .         .
sensing_good   .         .         .         .         .         tracking  .         .
"""
HEADER, *ROWS = EXPECTED.strip().splitlines()
TABLE = {
    (Mode(mode), Event(row.split()[0].replace("_", " "))): following
    for row in ROWS
    for mode, following in zip(HEADER.split(), row.split()[1:], strict=True)
}


def happening(event):
    return Happening(event=event, reason=f"because of {event}")


def test_the_table_of_this_test_is_complete():
    assert set(TABLE) == set(itertools.product(Mode, Event))


@pytest.mark.parametrize(("mode", "event"), TABLE, ids=lambda value: value.value.replace(" ", "_"))
def test_every_pair(mode, event):
    before = Supervision(mode=mode, reason="before", since_s=1.0)
    after, (allowed,) = next_state(before, [happening(event)], [], 2.0)
    if TABLE[mode, event] in (".", mode.value):
        assert after == before
        assert allowed == (TABLE[mode, event] != ".")
    else:
        assert after == Supervision(mode=Mode(TABLE[mode, event]), reason=f"because of {event}", since_s=2.0)
        assert allowed


@pytest.mark.parametrize("mode", Mode)
def test_a_fault_takes_torque_wherever_there_is_some(mode):
    before = Supervision(mode=mode, reason="before", since_s=1.0)
    after, _ = next_state(before, [], [TravelError("first"), DriveLostError("second")], 2.0)
    if mode.torque:
        assert after == Supervision(mode=Mode.FAULT, reason="first", since_s=2.0)
    else:
        assert after == before


events = st.lists(st.sampled_from(Event), max_size=4)
faults = st.sampled_from([[], [DriveLostError("lost")]])


@given(st.sampled_from(Mode), events, events, faults)
def test_stop_wins_whatever_happens_beside_it(mode, earlier, later, fault):
    happenings = [happening(event) for event in (*earlier, Event.STOP, *later)]
    after, allowed = next_state(Supervision(mode=mode), happenings, fault, 2.0)
    assert not after.mode.torque
    assert all(allowed[index] == (h.event is Event.STOP) for index, h in enumerate(happenings))


@given(st.lists(st.tuples(events, faults), max_size=20))
def test_torque_comes_on_by_home_only_and_faults_are_left_by_the_operator_only(cycles):
    current = Supervision()
    for happened, fault in cycles:
        following, _ = next_state(current, [happening(event) for event in happened], fault, 0.0)
        if following.mode.torque and not current.mode.torque:
            assert Event.HOME in happened
        if current.mode is Mode.FAULT and following.mode is not Mode.FAULT:
            assert {Event.HOME, Event.RELAX} & set(happened)
        current = following


def test_a_start_is_in_idle_and_says_the_bench_s_own_words():
    assert Supervision().mode is Mode.IDLE
    assert {mode.state for mode in Mode} == set(State)
    assert {Event(action.value) for action in Action if action is not Action.STATUS} == {
        Event.HOME, Event.ARM, Event.HOLD, Event.RELAX, Event.STOP,
    }  # fmt: skip
