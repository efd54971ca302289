"""Jogs, pauses, aborts and other orders: what they do, where they are possible, and that nothing moves on its own."""

import dataclasses

import numpy as np
import pytest

from controller.cycle import LoopState
from messaging.control import Action, ActionRequest

PERIOD_S = 0.005


def commands(moments):
    """(n, A) of all cycles that sent one."""
    return np.array([m.outputs.command_mm for m in moments if m.outputs.command_mm is not None])


def place(bench, node="tip"):
    """Where the reference leads a nodal point just now."""
    reference = bench.state.task.reference
    return reference.at(bench.now_s).node_mm[reference.target.node_names.index(node)]


@pytest.mark.parametrize(("axis", "index", "distance_mm"), [("2", 1, -0.4), ("stage", 4, 3.0)])
def test_a_jog_moves_one_axis_slowly_and_the_robot_stays_homed(homed, axis, index, distance_mm):
    reply = homed.jog(axis, distance_mm)
    assert (reply.accepted, reply.state) == (True, "hold")
    assert "the operator jogs" in reply.reason
    moments, _ = homed.run(abs(distance_mm) + 0.1)
    sent = commands(moments)
    np.testing.assert_allclose(sent[-1], distance_mm * np.eye(5)[index], atol=1e-9)
    assert np.abs(np.diff(sent, axis=0)).max() <= 1.0 * PERIOD_S * 1.001
    name = "stage" if axis == "stage" else f"tendon {axis}"
    assert moments[0].outputs.reason == f"the operator jogs {name} by {distance_mm:g} mm"
    assert homed.state.jog is None
    assert homed.do("arm").accepted


def test_a_jog_before_homing_holds_in_a_state_of_its_own(paper_bench):
    reply = paper_bench.jog("3", 1.0, 0.5)
    assert (reply.accepted, reply.state) == (True, "unhomed")
    assert paper_bench.servos.torque
    refused = [paper_bench.do(action) for action in ("arm", "pause", "resume", "abort")]
    assert not any(reply.accepted for reply in refused)
    moments, _ = paper_bench.run(1.0)
    np.testing.assert_allclose(commands(moments)[-1], np.eye(5)[2])
    assert {moment.state.mode for moment in moments} == {"unhomed"}
    assert paper_bench.jog("3", -1.0, 1.2).accepted
    np.testing.assert_allclose(paper_bench.state.command_mm, 0.0, atol=1e-12)
    assert paper_bench.do("home").accepted
    paper_bench.run(8.0)
    assert paper_bench.state.mode == "ready"


@pytest.mark.parametrize("order", ["stop", "relax"])
def test_tendons_that_were_never_homed_are_let_go_at_once(paper_bench, order):
    paper_bench.jog("1", 1.0, 0.3)
    assert paper_bench.do(order).state == "idle"
    assert not paper_bench.servos.torque


def test_every_other_order_ends_a_jog(homed):
    homed.jog("1", 2.0, 0.5)
    assert homed.do("hold").accepted
    assert (np.ptp(commands(homed.run(0.5)[0]), axis=0) == 0).all()
    homed.jog("1", 2.0, 0.5)
    homed.jog("2", -1.0, 1.5)
    np.testing.assert_allclose(homed.state.command_mm[1], -1.0)
    assert 0.5 < homed.state.command_mm[0] < 1.1
    homed.jog("1", 2.0, 0.1)
    assert homed.do("stop", 0.1).accepted
    assert homed.state.jog is None


@pytest.mark.parametrize(
    ("axis", "distance_mm", "words"),
    [
        ("6", 1.0, "there is no axis '6'; known are 1, 2, 3, 4, stage"),
        ("", 1.0, "there is no axis ''"),
        ("1", 0.0, "it must be some way, and at most 5 mm"),
        ("1", 5.1, "a jog of 5.1 mm: it must be some way, and at most 5 mm"),
        ("stage", -1.0, "stage would come to -1 mm; its travel is 0 to 40 mm"),
    ],
)
def test_a_jog_that_cannot_be_is_refused_and_nothing_moves(homed, axis, distance_mm, words):
    reply = homed.jog(axis, distance_mm, 0.1)
    assert not reply.accepted
    assert words in reply.reason
    assert homed.state.mode == "ready"
    assert not homed.state.command_mm.any()


def test_jogs_do_not_add_up_beyond_the_travel(paper_bench):
    assert paper_bench.jog("1", 4.0, 4.1).accepted
    assert "tendon 1 would come to 8 mm; its travel is -5 to 5 mm" in paper_bench.jog("1", 4.0).reason
    paper_bench.drive_absent = "unplugged"
    paper_bench.run(0.1)
    assert "no tendon drive: unplugged" in paper_bench.jog("1", 1.0).reason
    assert "jog is not possible in fault" in refused_in_fault(paper_bench).reason


def refused_in_fault(bench):
    bench.drive_absent = ""
    return bench.jog("1", 1.0)


def test_a_jog_is_guarded_by_the_current(homed):
    homed.jog("1", 2.0, 0.2)
    homed.servos.current_ma = 1500.0
    homed.run(0.15)
    assert homed.state.supervision.fault.code == "excess_current"
    assert not homed.servos.torque


def test_a_pause_stands_on_the_path_in_closed_loop_and_resume_goes_on_from_there(tracking):
    assert tracking.do("pause", 1.5).accepted
    assert tracking.state.mode == "tracking"
    assert tracking.state.paused
    stood, progress = place(tracking), tracking.state.progress
    moments, _ = tracking.run(1.0)
    assert moments[-1].outputs.reason == "paused by the operator"
    np.testing.assert_allclose(place(tracking), stood, atol=1e-9)
    assert tracking.state.progress == pytest.approx(progress, abs=1e-9)
    assert np.linalg.norm(tracking.node_mm[1] - stood) < 0.2
    assert tracking.do("resume", 1.0).accepted
    assert not tracking.state.paused
    gone = np.linalg.norm(place(tracking) - stood)
    assert 3.0 < gone < 10.0
    assert tracking.state.progress > progress


def test_a_pause_outlives_lost_shapes_and_a_new_target(tracking, stand_ins):
    tracking.do("pause", 1.0)
    see, tracking.camera = tracking.camera, lambda _: None
    tracking.run(0.5)
    assert tracking.state.mode == "waiting"
    assert tracking.state.paused
    tracking.camera = see
    tracking.run(1.0)
    assert tracking.state.mode == "tracking"
    stood = place(tracking)
    tracking.run(0.5)
    np.testing.assert_allclose(place(tracking), stood, atol=1e-9)
    assert tracking.run(1.0, stand_ins["pose"]((5.0, 0.0, 84.0)))[1][0].accepted
    stood = place(tracking)
    tracking.run(0.5)
    np.testing.assert_allclose(place(tracking), stood, atol=1e-9)
    tracking.do("resume", 4.0)
    assert np.linalg.norm(tracking.node_mm[1] - [5.0, 0.0, 84.0]) < 0.3
    assert tracking.state.progress == 1.0


def test_a_motion_that_waits_for_shapes_can_be_paused_and_resumed(tracking):
    see, tracking.camera = tracking.camera, lambda _: None
    tracking.run(0.3)
    reply = tracking.do("pause")
    assert (reply.accepted, reply.state) == (True, "hold")
    assert "no trusted shape" in reply.reason
    tracking.camera = see
    tracking.run(1.0)
    assert tracking.state.mode == "tracking"
    stood = place(tracking)
    tracking.run(0.5)
    np.testing.assert_allclose(place(tracking), stood, atol=1e-9)
    tracking.camera = lambda _: None
    tracking.run(0.3)
    assert tracking.do("resume").accepted
    tracking.camera = see
    tracking.run(1.5)
    assert np.linalg.norm(place(tracking) - stood) > 3.0


@pytest.mark.parametrize("order", ["hold", "relax", "stop", "abort"])
def test_a_pause_ends_with_its_motion(tracking, order):
    tracking.do("pause", 0.5)
    tracking.do(order)
    assert not tracking.state.paused


def test_abort_holds_where_the_tendons_are_and_forgets_the_target(tracking):
    assert tracking.do("abort").state == "hold"
    assert (np.ptp(commands(tracking.run(0.5)[0]), axis=0) == 0).all()
    assert tracking.state.target is None
    assert tracking.state.progress == 0.0
    assert tracking.do("arm", 1.0).accepted
    assert (np.ptp(commands(tracking.run(0.5)[0]), axis=0) == 0).all()


def test_orders_and_targets_of_one_cycle_are_obeyed_one_after_the_other(tracking, stand_ins):
    abort, hold, pause, arm = (
        ActionRequest(action=action) for action in (Action.ABORT, Action.HOLD, Action.PAUSE, Action.ARM)
    )
    pose = stand_ins["pose"]((5.0, 0.0, 84.0))
    tracking.run(0.1, pause, arm)
    assert tracking.state.paused
    tracking.run(0.1, abort, hold)
    assert tracking.state.target is None
    tracking.run(0.1, pose, abort)
    assert tracking.state.target is None
    tracking.run(0.1, abort, pose, arm)
    assert tracking.state.target.name == "pose"
    assert tracking.state.mode == "tracking"


def test_progress_of_a_pose_reaches_one_and_is_kept_by_a_hold(homed, stand_ins):
    homed.run(PERIOD_S, stand_ins["pose"]((6.0, 0.0, 83.0)))
    assert homed.state.progress == 0.0
    homed.do("arm", 0.3)
    assert 0.0 < homed.state.progress < 1.0
    homed.do("hold", 0.1)
    kept = homed.state.progress
    assert 0.0 < kept < 1.0
    homed.do("arm", 4.0)
    assert homed.state.progress == 1.0


def blink(bench):
    see, bench.camera = bench.camera, lambda _: None
    bench.run(0.3)
    assert bench.state.mode == "waiting"
    bench.camera = see
    return bench.run(0.3)[0]


def hold(bench):
    bench.do("hold", 0.1)
    bench.do("arm")
    return bench.run(0.3)[0]


@pytest.mark.parametrize("interrupt", [blink, hold])
def test_progress_along_a_path_goes_on_where_it_was_interrupted_and_never_back(homed, stand_ins, interrupt):
    line = stand_ins["led"]([0.0, 1.0, 2.0], [[-3.0, 0.0, 83.0], [0.0, 0.0, 84.0], [3.0, 0.0, 83.0]])
    assert homed.run(PERIOD_S, line)[1][0].accepted
    homed.do("arm")
    while homed.state.progress < 0.8:
        homed.cycle(())
    moments = interrupt(homed) + homed.run(2.5)[0]
    progress = [moment.state.progress for moment in moments]
    assert progress[0] >= 0.8
    assert (np.diff(progress) >= 0).all()
    assert progress[-1] == 1.0


@pytest.mark.parametrize("action", [action for action in Action if action is not Action.STATUS])
def test_stop_beside_any_order_and_any_target_wins(tracking, stand_ins, action):
    order = ActionRequest(action=action, axis="1", distance_mm=1.0)
    stop = ActionRequest(action=Action.STOP)
    _, replies = tracking.run(PERIOD_S, order, stand_ins["pose"]((5.0, 0.0, 84.0)), stop, order)
    assert tracking.state.mode == "idle"
    assert not tracking.servos.torque
    assert [reply.accepted for reply in replies] == [
        action is Action.STOP,
        False,
        True,
        action is Action.STOP,
    ]
    assert replies[1].reason == "target pose is void: a stop came in the same cycle"
    tracking.run(0.5)
    assert tracking.state.mode == "idle"


def test_what_the_loop_remembers_survives_a_snapshot(tracking, homed, paper_bench):
    tracking.do("pause", 0.1)
    homed.jog("1", 1.0, 0.1)
    paper_bench.run(0.2)
    paper_bench.do("home", 0.5)
    assert paper_bench.state.search is not None
    for bench in (tracking, homed, paper_bench):
        again = LoopState.from_bytes(bench.state.to_bytes())
        assert again.to_bytes() == bench.state.to_bytes()
        twin = dataclasses.replace(bench.state)
        bench.state = again
        bench.run(0.2)
        assert twin is not bench.state
