"""What comes together in one cycle: homing that ends beside orders, orders beside one another, faults and stops beside all."""

from typing import Any

import numpy as np
import pytest

from controller.law import Law
from controller.supervisor import Mode
from messaging.control import Action, ActionRequest

PERIOD_S = 0.005


def orders(*actions):
    """One request each; a jog is of the first tendon."""
    return tuple(ActionRequest(action=Action(action), axis="1", distance_mm=1.0) for action in actions)


@pytest.mark.parametrize("beside", [("arm",), ("hold",), ("jog",), ("abort", "arm"), ("home",)])
def test_an_order_beside_the_end_of_homing_does_not_take_its_zero_away(paper_bench, stand_ins, beside):
    paper_bench.run(0.2, stand_ins["circle"]())
    paper_bench.do("home")
    while paper_bench.state.mode is Mode.HOMING:
        moment = paper_bench.cycle(orders(*beside))
    assert moment.state.mode is Mode.READY
    assert not any(reply.accepted for reply in moment.outputs.replies)
    np.testing.assert_array_equal(moment.outputs.zero_mm, np.zeros(5))
    np.testing.assert_array_equal(moment.outputs.command_mm, np.zeros(5))


@pytest.mark.parametrize(("order", "follows"), [("relax", Mode.IDLE), ("stop", Mode.IDLE)])
def test_what_lets_go_beside_the_end_of_homing_wins(paper_bench, order, follows):
    paper_bench.run(0.2)
    paper_bench.do("home")
    while paper_bench.state.mode is Mode.HOMING:
        before = paper_bench.state
        paper_bench.cycle(())
    paper_bench.state = before
    moment = paper_bench.cycle(orders(order))
    assert moment.state.mode is follows
    assert moment.outputs.zero_mm is None
    assert moment.outputs.release


@pytest.mark.parametrize("first", ["abort", "relax"])
def test_what_forgets_the_target_and_an_arm_beside_it_leave_nothing_to_follow(tracking, first):
    tracking.run(PERIOD_S, *orders(first, "arm"))
    assert tracking.state.mode is Mode.TRACKING
    assert (tracking.state.target, tracking.state.task) == (None, None)
    assert tracking.state.learnt is not None
    moments, _ = tracking.run(0.3)
    assert (np.ptp([moment.outputs.command_mm for moment in moments], axis=0) == 0).all()


def test_of_several_targets_the_last_one_counts(tracking, stand_ins):
    pose = stand_ins["pose"]
    first, last = pose((5.0, 0.0, 84.0), name="first"), pose((0.0, 5.0, 84.0), name="last")
    moments, replies = tracking.run(PERIOD_S, first, *orders("abort"), last)
    assert [reply.accepted for reply in replies] == [False, True, True]
    assert replies[0].reason == "target first is void: target last came in the same cycle"
    assert moments[0].outputs.accepted is last
    assert tracking.state.target is last


def test_a_target_that_an_order_behind_it_forgets_is_not_said_to_be_new(tracking, stand_ins):
    moments, _ = tracking.run(PERIOD_S, stand_ins["pose"]((5.0, 0.0, 84.0)), *orders("abort"))
    assert moments[0].outputs.accepted is None


@pytest.mark.parametrize("trouble", ["stop", "alarm"])
def test_beside_a_stop_or_a_fault_no_target_is_looked_at(tracking, stand_ins, trouble, monkeypatch):
    looked = []
    monkeypatch.setattr("controller.orders.check_target", lambda *args, **others: looked.append(args))
    tracking.servos.hardware_error = int(trouble == "alarm")
    _, replies = tracking.run(
        PERIOD_S, stand_ins["pose"]((5.0, 0.0, 84.0)), *orders(*["stop"][: trouble == "stop"])
    )
    assert not looked
    assert not replies[0].accepted
    assert "target pose is void: " in replies[0].reason
    assert tracking.state.target is None


class NeverStarts(Law[None]):
    """A law that fails when it should begin."""

    lead_s = 0.0

    def start(self, beginning):
        raise ValueError("not today")

    def step(self, state: Any, inputs):
        raise NotImplementedError


def test_an_order_that_ends_in_a_fault_was_not_accepted_nor_was_what_came_beside_it(homed, stand_ins):
    homed.loop._motion._law = NeverStarts()
    moments, replies = homed.run(PERIOD_S, stand_ins["pose"]((5.0, 0.0, 84.0)), *orders("arm", "status"))
    assert homed.state.mode is Mode.FAULT
    assert [reply.accepted for reply in replies] == [False, False, True]
    assert {(reply.state, reply.fault) for reply in replies} == {("fault", "law_failed")}
    assert replies[1].reason.startswith("arm is void: the law failed: ValueError: not today")
    assert moments[0].outputs.accepted is None
    assert homed.state.target is None


def test_a_target_of_too_many_positions_is_refused_in_words(homed, stand_ins):
    seconds = np.linspace(0.0, 600.0, 5001)
    long = stand_ins["led"](seconds, np.tile([0.0, 0.0, 82.0], (len(seconds), 1)))
    _, (reply,) = homed.run(PERIOD_S, long)
    assert reply.reason == ("target path: 5001 moments of 1 nodal points; their product may be 5000 at most")


@pytest.mark.parametrize("ended", ["stop", "alarm", "relax", "abort"])
def test_what_ends_a_motion_for_good_forgets_its_target(tracking, ended):
    tracking.servos.hardware_error = int(ended == "alarm")
    tracking.run(PERIOD_S, *([] if ended == "alarm" else orders(ended)))
    state = tracking.state
    assert (state.target, state.joined_s, state.progress) == (None, 0.0, 0.0)


def test_homing_keeps_the_target_and_begins_it_anew(tracking):
    tracking.do("hold")
    assert tracking.state.joined_s > 1.0
    tracking.do("home")
    assert tracking.state.target.name == "circle"
    assert (tracking.state.joined_s, tracking.state.progress) == (0.0, 0.0)
