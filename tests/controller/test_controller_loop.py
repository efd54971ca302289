"""The loop as a whole, in virtual time: what it does when all is well, and what it does about everything that is not."""

import copy
import dataclasses
import re
from typing import Any

import numpy as np
import pytest

from controller.law import Law
from controller.loop import Loop
from controller.settings import ControllerSettings, HomingSettings, SectionTendons
from controller.supervisor import Mode
from messaging.control import Action, ActionRequest, State, Target
from messaging.settings import RobotSettings

PERIOD_S = 0.005


def first(moments, mode):
    """The first moment in this mode."""
    return next(moment for moment in moments if moment.state.mode == mode)


def test_homing_makes_the_robot_straight_and_calls_that_zero(paper_bench):
    assert np.abs(paper_bench.node_mm[:, :2]).max() > 0.5
    paper_bench.home()
    assert np.abs(paper_bench.node_mm[:, :2]).max() < 0.5
    np.testing.assert_allclose(paper_bench.state.command_mm, np.zeros(5))
    np.testing.assert_allclose(paper_bench.servos.position_mm, np.zeros(5), atol=1e-9)
    assert paper_bench.servos.torque


def test_no_step_is_faster_than_a_nodal_point_may_move(tracking, stand_ins):
    tracking.run(PERIOD_S, stand_ins["pose"]((-20.0, 5.0, 85.0)))
    moments, _ = tracking.run(4.0)
    tips = np.array([moment.node_mm[1] for moment in moments])
    speed = np.linalg.norm(tips[20:] - tips[:-20], axis=1) / (20 * PERIOD_S)
    assert speed.max() < 20.0 * 1.25  # the robot answers more strongly than its model, until that is learnt
    assert np.linalg.norm(tips[-1] - [-20.0, 5.0, 85.0]) < 0.1


def test_without_a_target_arming_keeps_the_place(homed):
    assert homed.do("arm", 1.0).accepted
    np.testing.assert_array_equal(homed.state.command_mm, np.zeros(5))
    assert homed.state.mode == "tracking"


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda shape, make: None, "none has come since"),
        (lambda shape, make: make([], [], refusal="the robot is out of view"), "refused: the robot is out of view"),
        (lambda shape, make: dataclasses.replace(shape, flags=("tip_unseen",)), "flagged: tip_unseen"),
        (lambda shape, make: dataclasses.replace(shape, node_names=("a", "b")), "no nodal point tip"),
        (lambda shape, make: dataclasses.replace(shape, node_arc_mm=[40, 70]), "moved by 10.0 mm along the robot"),
    ],
)  # fmt: skip
def test_untrusted_shapes_hold_within_100_ms_and_then_fault(tracking, stand_ins, spoil, reason):
    tracking.camera = lambda shape: spoil(shape, stand_ins["shape_of"])
    moments, _ = tracking.run(1.5)
    held = first(moments, "waiting")
    last_good_s = held.state.seen.arrived_s
    assert held.state.mode.state is State.HOLD
    assert 0.085 < held.now_s - last_good_s <= 0.1
    assert reason in held.outputs.reason
    still = [m.outputs.command_mm for m in moments if m.state.mode == "waiting"]
    assert (np.ptp(still, axis=0) == 0).all()
    fault = first(moments, "fault")
    assert fault.now_s - last_good_s == pytest.approx(1.0, abs=0.02)
    assert "no trusted shape for 1.0" in fault.outputs.reason
    assert reason in fault.outputs.reason
    assert fault.outputs.release
    assert fault.outputs.command_mm is None


def test_a_shape_that_took_too_long_is_as_good_as_none(tracking):
    tracking.extra_delay_s = 0.1
    moments, _ = tracking.run(1.2)
    assert first(moments, "waiting").now_s - moments[0].now_s < 0.2
    assert "ms after its capture, 100 ms are allowed" in first(moments, "fault").outputs.reason


def test_tracking_goes_on_by_itself_when_shapes_are_good_again_where_it_left_the_path(tracking):
    path_s = tracking.state.task.reference.path_s(tracking.now_s)
    tracking.camera = lambda _: None
    tracking.run(0.5)
    assert tracking.state.mode == "waiting"
    tracking.camera = lambda shape: shape
    moments, _ = tracking.run(2.0)
    resumed = first(moments, "tracking")
    assert resumed.outputs.reason == "shapes are trusted again"
    belief = resumed.state.task.law_state.belief
    assert not np.allclose(belief.mean, belief.nominal), "what the law has learnt is lost"
    assert resumed.state.task.reference.path_s(resumed.now_s) == pytest.approx(path_s, abs=0.15)
    assert moments[-1].state.task.error_mm < 0.5


def test_homing_stands_still_without_trusted_shapes_and_goes_on_with_them(paper_bench):
    paper_bench.run(0.2)
    paper_bench.do("home", 0.3)
    paper_bench.camera = lambda _: None
    moments, _ = paper_bench.run(0.5)
    commands = np.array([m.outputs.command_mm for m in moments])
    assert (np.ptp(commands[:20], axis=0) > 0).any()
    assert (np.ptp(commands[34:], axis=0) == 0).all()
    paper_bench.camera = lambda shape: shape
    paper_bench.run(10.0)
    assert paper_bench.state.mode == "ready"


def test_a_target_given_while_waiting_is_followed_or_the_wait_ends_in_a_fault(tracking, stand_ins):
    see = tracking.camera
    tracking.camera = lambda _: None
    tracking.run(0.3)
    assert tracking.run(0.1, stand_ins["pose"]((5.0, 0.0, 84.0)))[1][0].accepted
    patient = copy.deepcopy(tracking)
    tracking.camera = see
    tracking.run(3.0)
    assert tracking.state.mode == "tracking"
    assert np.linalg.norm(tracking.node_mm[1] - [5.0, 0.0, 84.0]) < 0.2
    patient.camera = lambda shape: dataclasses.replace(shape, node_names=("a", "b"))
    patient.run(1.0)
    assert "no nodal point tip" in patient.state.supervision.reason
    assert patient.state.mode == "fault"


def test_the_operators_hold_does_not_end_by_itself_and_does_not_need_shapes(tracking):
    assert tracking.do("hold", 1.0).accepted
    tracking.camera = lambda _: None
    moments, _ = tracking.run(3.0)
    assert {moment.state.mode for moment in moments} == {Mode.HOLD}
    refused = tracking.do("arm")
    assert not refused.accepted
    assert "no trusted shape" in refused.reason


@pytest.fixture(params=["homing", "ready", "tracking", "paused", "hold", "waiting", "relaxing", "unhomed"])
def powered(request, paper_bench, homed, tracking):
    """A bench in each of the modes with torque."""
    bench = {"homing": paper_bench, "unhomed": paper_bench, "ready": homed}.get(request.param, tracking)
    if request.param == "homing":
        bench.run(0.2)
        bench.do("home", 0.3)
    elif request.param == "unhomed":
        bench.jog("2", 1.0, 0.3)
    elif request.param == "paused":
        bench.do("pause", 0.3)
        assert bench.state.paused
    elif request.param == "waiting":
        bench.camera = lambda _: None
        bench.run(0.3)
    elif request.param in ("hold", "relaxing"):
        bench.do({"hold": "hold", "relaxing": "relax"}[request.param])
    assert bench.state.mode == ("tracking" if request.param == "paused" else request.param)
    return bench


def test_stop_wins_within_one_cycle(powered):
    (moment,), replies = powered.run(
        PERIOD_S, *(ActionRequest(action=Action(action)) for action in ("arm", "stop", "home"))
    )
    assert [reply.accepted for reply in replies] == [False, True, False]
    assert moment.outputs.release
    assert moment.outputs.command_mm is None
    assert moment.state.mode == "idle"
    assert not powered.servos.torque


def unplug(bench):
    bench.drive_absent = "/dev/ttyUSB0: the port is gone"


def alarm(bench):
    bench.servos.hardware_error = 0x20


def let_go(bench):
    bench.servos.torque = False


def overload(bench):
    bench.servos.current_ma = 1234.0


def run_away(bench):
    bench.servos.position_mm = bench.servos.position_mm + 9.0 * np.eye(5)[1]


TROUBLES = {
    unplug: "/dev/ttyUSB0: the port is gone",
    alarm: r"hardware error bits: tendon 1 0x20 \(pair 1: overload\)",
    let_go: "let its tendon go",
    overload: "tendon 1 draws 1234 mA for more than 0.1 s; at most 800 mA are allowed",
    run_away: r"tendon 2: .* mm, travel -5 to 5",
}


@pytest.mark.parametrize("trouble", [trouble for trouble in TROUBLES if trouble is not overload])
def test_stop_beside_trouble_is_obeyed_and_the_trouble_is_not_forgotten(powered, trouble):
    trouble(powered)
    (moment,), (reply,) = powered.run(PERIOD_S, ActionRequest(action=Action.STOP))
    assert reply.accepted
    assert moment.outputs.release
    assert moment.outputs.command_mm is None
    assert moment.state.mode == "fault"
    assert re.search(TROUBLES[trouble], reply.reason)
    assert reply.fault


@pytest.mark.parametrize("trouble", TROUBLES)
def test_trouble_with_the_drive_is_a_fault_that_only_the_operator_leaves(powered, trouble):
    trouble(powered)
    moments, _ = powered.run(0.15)
    fault = first(moments, "fault")
    assert fault.now_s - moments[0].now_s <= (0.11 if trouble is overload else PERIOD_S)
    assert re.search(TROUBLES[trouble], fault.outputs.reason)
    assert fault.outputs.release
    assert all(m.outputs.command_mm is None for m in moments if m.state.mode == "fault")
    powered.drive_absent = ""
    powered.servos.hardware_error, powered.servos.current_ma = 0, 100.0
    assert not powered.do("arm", 0.2).accepted
    assert not powered.do("hold").accepted
    assert powered.state.mode == "fault"
    assert powered.do("relax").state == "idle"
    assert not powered.servos.torque


def test_a_short_current_peak_is_no_fault(tracking):
    for _ in range(5):
        tracking.servos.current_ma = 1500.0
        tracking.run(0.08)
        tracking.servos.current_ma = 100.0
        tracking.run(PERIOD_S)
    assert tracking.state.mode == "tracking"


class Beyond(Law[None]):
    """A law that asks for more than the first tendon's travel."""

    lead_s = 0.0

    def start(self, beginning):
        return None

    def step(self, state: Any, inputs):
        return None, inputs.command_mm + 6.0 * np.eye(5)[0]


def test_pushing_against_the_end_of_a_travel_is_said_and_then_a_fault(tracking):
    tracking.loop._motion._law = Beyond()
    moments, _ = tracking.run(6.0)
    assert any("mm asked, travel -5 to 5" in m.outputs.reason for m in moments if m.state.mode == "tracking")
    assert "pushed for more than 1 s beyond travel" in first(moments, "fault").outputs.reason


def test_homing_that_does_not_end_is_a_fault(stand_ins):
    settings = ControllerSettings(homing=HomingSettings(timeout_s=2.0, find_slack=False))
    stiff = stand_ins["PaperRobot"](
        settings.kinematics(stand_ins["ROBOT"]), gain=0.0, offset_mm=(3.0, 0.0, 0.0)
    )
    bench = stand_ins["VirtualBench"](stiff, settings)
    bench.run(0.2)
    bench.do("home")
    moments, _ = bench.run(3.0)
    assert "not straight within 0.5 mm after 2 s" in first(moments, "fault").outputs.reason


def test_relax_leads_the_tendons_back_slowly_and_lets_go(tracking):
    before = np.abs(tracking.state.command_mm[:-1]).max()
    assert tracking.do("relax").accepted
    moments, _ = tracking.run(before / 1.0 + 0.5)
    commands = np.array([m.outputs.command_mm for m in moments if m.outputs.command_mm is not None])
    assert np.abs(np.diff(commands, axis=0)).max() <= 1.0 * PERIOD_S * 1.001
    np.testing.assert_allclose(commands[-1, :-1], 0.0, atol=1e-9)
    assert first(moments, "idle").outputs.release
    assert not tracking.servos.torque


def test_refusals_say_why(paper_bench, stand_ins):
    paper_bench.camera = lambda _: None
    paper_bench.drive_absent = "/dev/ttyUSB0: there is no such device"
    assert "there is no such device" in paper_bench.do("home").reason
    paper_bench.drive_absent = ""
    assert paper_bench.do("home").reason == "no trusted shape: none has come"
    assert not paper_bench.do("arm").accepted
    assert "not possible in idle" in paper_bench.do("hold").reason
    _, (reply,) = paper_bench.run(PERIOD_S, stand_ins["circle"]())
    assert "sensing reports none" in reply.reason
    paper_bench.camera = lambda shape: shape
    paper_bench.run(0.2)
    _, (reply,) = paper_bench.run(PERIOD_S, stand_ins["pose"]((0.0, 0.0, 500.0)))
    assert not reply.accepted
    assert "stage travels" in reply.reason
    status = paper_bench.do("status")
    assert (status.accepted, status.state, status.reason) == (True, "idle", "started")
    paper_bench.drive_absent = "/dev/ttyUSB0: there is no such device"
    assert paper_bench.do("status").reason == paper_bench.drive_absent


def test_a_new_target_is_said_once_and_joined_from_where_the_old_one_led(tracking, stand_ins):
    led = tracking.state.task.reference.at(tracking.now_s).node_mm
    moments, _ = tracking.run(0.1, stand_ins["pose"]((0.0, 0.0, 85.0)))
    assert [m.outputs.accepted.name for m in moments if m.outputs.accepted is not None] == ["pose"]
    np.testing.assert_array_equal(moments[0].state.task.reference.start_mm, led)


def test_several_weighted_points_are_followed_together(homed, stand_ins):
    kinematics = ControllerSettings().kinematics(stand_ins["ROBOT"])
    goal = kinematics.nodes_mm(np.array([0.8, 0.3, 0.2, -0.9, 4.0]), np.array([40.0, 80.0]))
    both = Target(
        name="both",
        node_names=("tip", "middle"),
        weights=[1.0, 2.0],
        time_s=[0.0],
        position_mm=goal[None, ::-1],
        repeat=False,
    )
    _, (reply,) = homed.run(PERIOD_S, both)
    assert reply.accepted, reply
    homed.do("arm", 4.0)
    np.testing.assert_allclose(homed.node_mm, goal, atol=0.35)


def test_three_sections_work_too(stand_ins):
    robot = RobotSettings(section_length_mm=(30.0, 30.0, 30.0))
    settings = ControllerSettings(
        sections=tuple(SectionTendons(pair_angle_deg=(30.0 * n, 30.0 * n + 90)) for n in range(3))
    )
    paper = stand_ins["PaperRobot"](settings.kinematics(robot), node_arc_mm=(30.0, 90.0))
    bench = stand_ins["VirtualBench"](paper, settings, node_arc_mm=(30.0, 90.0), section_settings=robot)
    bench.home()
    assert bench.run(PERIOD_S, stand_ins["circle"](z_mm=92.0))[1][0].accepted
    bench.do("arm", 5.0)
    assert bench.state.mode == "tracking"
    assert bench.state.task.error_mm < 0.3


class Nonsense(Law[None]):
    """A law whose command is not finite."""

    lead_s = 0.0

    def start(self, points, command_mm, measured, now_s):
        return None

    def step(self, state: Any, inputs):
        return None, np.full_like(inputs.command_mm, np.nan)


def test_a_law_that_says_nan_is_a_fault_and_nothing_is_sent(tracking):
    tracking.loop._motion._law = Nonsense()
    moments, _ = tracking.run(PERIOD_S)
    assert moments[0].state.mode == "fault"
    assert "must be 5 finite numbers" in moments[0].outputs.reason
    assert moments[0].outputs.command_mm is None
    assert moments[0].outputs.release


def test_the_same_inputs_give_the_same_bytes(tracking):
    loop, seen, state = tracking.loop, [], tracking.state
    step = loop.step

    def watched(state, inputs):
        seen.append(inputs)
        return step(state, inputs)

    loop.step = watched
    moments, _ = tracking.run(0.5)
    again = Loop(ControllerSettings(), RobotSettings(section_length_mm=(40.0, 40.0)))
    for inputs, moment in zip(seen, moments, strict=True):
        state, outputs = again.step(state, inputs)
        assert outputs.command_mm.tobytes() == moment.outputs.command_mm.tobytes()
