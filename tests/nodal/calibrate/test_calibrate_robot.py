"""A robot that is led to be identified, on a bench in virtual time: what is found, what is refused, and what is kept."""

import dataclasses
import json
import re
import tomllib

import msgspec
import numpy as np
import pytest

from calibration.robot_plan import Reach, planned
from controller.laws.resolved_rate import Tuning
from controller.settings import ControllerSettings, HomingSettings, JogSettings, SectionTendons
from drivers.dynamixel.settings import AxisSettings
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings
from messaging.control import Action, ActionRequest
from messaging.settings import RobotSettings
from nodal.__main__ import main
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import read_bench
from nodal.calibrate.robot.experiment import experiment, reach
from nodal.calibrate.robot.leading import Leader
from nodal.calibrate.robot.nominal import NominalModel
from nodal.calibrate.robot.results import axes_found, identify
from nodal.calibrate.robot.walking import Walk
from nodal.calibrate.robot.wiring import find_wiring
from nodal.errors import JogRefusedError, RobotStoppedError
from nodal.virtual.bench import VirtualBench
from nodal.virtual.hand import VirtualHand
from nodal.virtual.settings import ServoSettings, ShapeSettings, VirtualBenchSettings

ONE_SECTION = VirtualBenchSettings(
    robot=SimulatedRobotSettings(centreline_points=21, sections=(SectionSettings(),)),
    shape=ShapeSettings(node_names=("middle", "tip"), node_arc_mm=(20.0, 40.0)),
    servos=ServoSettings(gain=(1.1, 0.8, 1.03)),
)
ROBOT = RobotSettings(section_length_mm=(40.0,))
NAMES = ("x", "y")
AXES = tuple(
    AxisSettings(name=name, id=servo, mm_per_rad=5.0, min_mm=-6.0, max_mm=6.0, max_current_ma=1000.0)
    for servo, name in enumerate(NAMES, start=1)
)


def controller(**settings):
    """Quicker than on a real bench, to be cheap."""
    return ControllerSettings(
        **{
            "sections": (SectionTendons(pair_angle_deg=(0.0, 90.0)),),
            "jog": JogSettings(mm_s=5.0),
            "homing": HomingSettings(probe_mm_s=2.0),
            **settings,
        }
    )


class Led:
    """A bench, and who leads it."""

    def __init__(self, **settings):
        self.settings = controller(**settings)
        self.bench = VirtualBench(ONE_SECTION, self.settings, ROBOT)
        self.bench.run(0.2)
        self.said = []
        self.leader = Leader(VirtualHand(self.bench), self.settings, 2, self.turned, self.said.append)
        self.kinematics = self.settings.kinematics(ROBOT)
        self.then = lambda: None

    def turned(self):
        self.then()

    def wiring(self):
        return find_wiring(self.leader, self.settings, self.kinematics, AXES)


@pytest.fixture
def led():
    return Led()


def test_a_servo_that_turns_the_other_way_is_found_and_all_is_back_where_it_was(led):
    led.bench.plant.mm_per_rad[1] *= -1
    wiring = led.wiring()
    assert wiring.reversed == (1,)
    assert led.bench.state.mode == "unhomed"
    np.testing.assert_allclose(led.leader.command_mm()[:2], 0.0, atol=1e-9)


def test_pairs_that_pull_what_the_other_should_are_named():
    led = Led(sections=(SectionTendons(pair_angle_deg=(90.0, 0.0)),))
    with pytest.raises(
        RobotStoppedError, match=r"tendon 1 \(x\) bends the robot as tendon 2 \(y\) should"
    ) as told:
        led.wiring()
    assert "exchange their id" in told.value.advice


def test_an_axis_that_nothing_follows_is_named_with_its_servo(led):
    led.bench.plant.robot.slip(np.array([0.0, 0.0, 100.0, 100.0]))
    with pytest.raises(RobotStoppedError, match=r"tendon 2 \(y\) was moved by 3 mm either way") as told:
        led.wiring()
    assert "servo 2" in told.value.advice


def test_a_servo_that_is_stuck_is_a_fault_with_advice(led):
    led.bench.plant.jammed.add(1)
    with pytest.raises(RobotStoppedError, match="tendon 2 draws") as told:
        led.wiring()
    assert told.value.advice


def test_a_fault_in_the_middle_of_a_move_ends_it_with_advice(led):
    led.leader.move(0, 3.0)
    begin_s = led.bench.now_s
    led.then = lambda: led.bench.plant.servos[0].fail(0x20) if led.bench.now_s > begin_s + 0.3 else None
    with pytest.raises(RobotStoppedError, match="ended in fault") as told:
        led.leader.move(0, -3.0)
    assert told.value.advice
    assert led.bench.state.mode == "fault"


def test_a_move_is_held_while_shapes_are_flagged_and_goes_on_when_they_are_not(led):
    led.leader.stand()
    begin_s = led.bench.now_s
    stood = []

    def spoil():
        since_s = led.bench.now_s - begin_s
        led.bench.seeing.flags = ("out_of_view",) if 0.1 < since_s < 2.0 else ()
        if 1.2 < since_s < 1.9:
            stood.append(float(led.bench.state.command_mm[0]))

    led.then = spoil
    led.leader.move(0, 5.0)
    assert len(set(stood)) == 1
    assert 0 < stood[0] < 5.0
    assert led.leader.command_mm()[0] == pytest.approx(5.0)


def test_shapes_that_stay_flagged_end_it(led):
    led.leader.stand()
    led.bench.seeing.flags = ("out_of_view",)
    with pytest.raises(RobotStoppedError, match="no trusted shape: shape flagged: out_of_view"):
        led.leader.move(0, 4.0)
    place = led.bench.state.command_mm.copy()
    led.bench.run(1.0)
    np.testing.assert_array_equal(led.bench.state.command_mm, place)


def test_a_refused_move_leaves_the_robot_where_it_is(led):
    led.leader.move(0, 4.0)
    with pytest.raises(JogRefusedError, match="its travel is"):
        led.leader.move(0, 9.0)
    assert led.bench.state.mode == "unhomed"


def test_who_stops_the_bench_stops_this_too(led):
    led.leader.move(0, 5.0)
    begin_s, stop = led.bench.now_s, ActionRequest(action=Action.STOP)
    led.then = lambda: led.bench.ask(stop) if led.bench.now_s > begin_s + 0.3 else None
    with pytest.raises(RobotStoppedError, match="ended in idle: the operator asked to stop"):
        led.leader.move(0, -5.0)


def silence(led, seconds, *, after_s):
    """The first servo says nothing for so long, from a while on; and the robot that was let go is seen badly for longer."""
    begin_s = led.bench.now_s + after_s

    def then():
        since_s = led.bench.now_s - begin_s
        led.bench.actuators.silent = {0} if 0 < since_s < seconds else set()
        led.bench.seeing.flags = ("base_unknown",) if 0 < since_s < seconds + 1.5 else ()

    led.then = then


def test_servos_that_are_silent_for_a_moment_cost_one_pose_and_no_more():
    led = Led(homing=HomingSettings(find_slack=False))
    walk = Walk(led.leader, print)
    walk.home()
    poses = np.array([[2.0, 0, 0], [-2.0, 0, 0], [0, 0, 0]])
    silence(led, 0.4, after_s=1.2)
    stands = walk.through(poses, "there", held_out=True)
    np.testing.assert_allclose([stand.position_mm for stand in stands], poses, atol=0.1)
    assert [(len(run.poses), run.held_out) for run in walk.runs] == [(1, 1), (2, 2)]
    assert len(led.said) == 1
    assert "no answer from servo 1; trying it again (1 of at most 2 times)" in led.said[0]


def test_servos_that_are_silent_while_it_is_found_out_which_way_tendons_bend_are_forgiven_too(led):
    led.bench.plant.mm_per_rad[1] *= -1
    silence(led, 0.4, after_s=2.0)
    assert led.wiring().reversed == (1,)
    assert len(led.said) == 1


def test_servos_that_are_silent_again_and_again_end_it():
    led = Led(homing=HomingSettings(find_slack=False))
    walk = Walk(led.leader, print)
    walk.home()

    def fail_in_every_move():
        led.bench.actuators.silent = {0} if led.bench.state.mode == "hold" else set()

    led.then = fail_in_every_move
    with pytest.raises(RobotStoppedError, match="no answer from servo 1"):
        walk.through(np.array([[2.0, 0, 0]]), "there")
    assert led.bench.state.mode == "fault"
    assert len(led.said) == 2


def test_another_fault_is_not_forgiven():
    led = Led(homing=HomingSettings(find_slack=False))
    walk = Walk(led.leader, print)
    walk.home()
    begin_s = led.bench.now_s
    led.then = lambda: led.bench.plant.servos[0].fail(0x20) if led.bench.now_s > begin_s + 0.3 else None
    with pytest.raises(RobotStoppedError, match="ended in fault"):
        walk.through(np.array([[2.0, 0, 0]]), "there")
    assert not led.said


def test_where_axes_stand_after_a_refused_move_is_recorded_with_the_controllers_reason():
    led = Led(homing=HomingSettings(find_slack=False))
    walk = Walk(led.leader, print)
    walk.home()
    stands = walk.through(np.array([[1.0, 0, 0], [2.0, 9.0, 0], [2.0, 9.0, 0], [0, 0, 0]]), "there")
    np.testing.assert_allclose(
        [stand.position_mm[:2] for stand in stands], [[1, 0], [2, 5], [0, 0]], atol=0.1
    )
    assert len(walk.refused) == 2
    assert all("its travel is" in reason for reason in walk.refused)


def test_nothing_but_refusals_end_it_with_the_reason():
    led = Led(homing=HomingSettings(find_slack=False))
    walk = Walk(led.leader, print)
    walk.home()
    with pytest.raises(
        RobotStoppedError, match=r"there: not one move is possible: jog was refused: .* its travel is"
    ):
        walk.through(np.array([[9.0, 0, 0]]), "there")


@pytest.fixture(scope="module")
def identified():
    led = Led(homing=HomingSettings(find_slack=False))
    within = Reach(tendon_mm=3.0, stage_mm=(0.0, 4.0))
    plan = planned(led.kinematics.command_of_coordinates[:2, :2], np.ones(2, bool), within, 8, 4)
    seen = experiment(led.leader, plan, print)
    led.leader.let_go()
    return led, seen, identify(seen, led.settings, led.leader.node_names, ROBOT, (5.0, 5.0, 1.0))


def test_moves_that_nobody_fitted_are_foreseen_several_times_better_than_by_the_drawing(identified):
    led, seen, outcome = identified
    foreseen = outcome.foreseen
    assert foreseen.poses == 4
    assert [run.held_out for run in seen.runs] == [0, 4]
    assert not outcome.doubt
    assert foreseen.before_mm > 0.05 * 40
    assert foreseen.after_mm < foreseen.before_mm / 2.5
    assert [node.name for node in foreseen.nodes] == ["middle", "tip"]
    assert led.bench.state.mode == "idle"


def test_what_is_said_to_be_foreseen_is_what_the_table_in_the_bench_file_foresees(identified):
    led, seen, outcome = identified
    known, kinematics = outcome.settings, led.kinematics
    model, run = NominalModel(kinematics, Tuning().engaging_mm), seen.runs[-1]
    felt = model.felt(run.poses.position_mm, np.append(known.lost_motion_mm, 0.0), np.zeros(3))
    turned = model.bend_of_coordinates @ (np.eye(2) + known.gain) @ model.coordinates_of_command
    nodes_mm = model.bent(felt @ turned.T + known.bias_rad, run.poses.arc_mm)
    nodes_mm[..., 2] += (1 + known.stage_gain[0]) * felt[:, -1:]
    missed_mm = np.linalg.norm(nodes_mm - run.poses.node_mm, axis=2)[-run.held_out :]
    assert np.sqrt((missed_mm**2).mean()) == pytest.approx(outcome.foreseen.after_mm, abs=0.02)


@pytest.mark.parametrize(
    ("name", "value", "doubt"),
    [
        (
            "stage_gain",
            [-0.97],
            r"stage_gain\[0\] is -0.97, beyond 0.9 either way: .* does the stage stand still",
        ),
        ("gain", [[0.0, 1.3], [0.0, 0.0]], r"gain\[0, 1\] is \+1.30"),
        ("bias_rad", [0.0, -1.2], r"bias_rad\[1\] is -1.20"),
    ],
)
def test_numbers_of_no_robot_are_doubted_instead_of_cut_off(identified, name, value, doubt):
    *_, outcome = identified
    estimate = dataclasses.replace(getattr(outcome.robot, name), value=np.array(value))
    robot = dataclasses.replace(outcome.robot, **{name: estimate})
    assert re.search(doubt, dataclasses.replace(outcome, robot=robot).doubt)


def test_gains_of_axes_and_stage_come_out_in_their_order(identified):
    led, seen, outcome = identified
    x, y = axes_found(outcome, seen, led.kinematics, NAMES)
    assert x.gain / y.gain == pytest.approx(1.1 / 0.8, abs=0.15)
    assert outcome.settings.stage_gain[0] == pytest.approx(0.03, abs=0.02)
    assert 0.2 < x.lost_motion_mm < 0.9
    assert x.current_between_ways_ma is not None
    assert x.current_between_ways_ma > 10


def test_what_is_found_goes_into_the_bench_file_and_comes_out_the_same(identified, tmp_path):
    *_, outcome = identified
    path = tmp_path / "bench.toml"
    path.write_text(
        'name = "b" # mine\n[servos]\nport = "p"\ntendons = [\n  { name = "x", id = 1, mm_per_rad = 5.0 }, # wound oddly\n'
        '  { name = "y", id = 2, mm_per_rad = 5.0 },\n]\n[recorder]\nfolder = "."\n'
    )
    edit_bench_file(path, {"servos": {"tendons": {1: {"mm_per_rad": -5.0}}}})
    edit_bench_file(path, {"controller": {"identified": msgspec.to_builtins(outcome.settings)}})
    text = path.read_text()
    assert '{ name = "y", id = 2, mm_per_rad = -5.0 }' in text
    assert '{ name = "x", id = 1, mm_per_rad = 5.0 }, # wound oddly' in text
    written = tomllib.loads(text)["controller"]["identified"]
    assert msgspec.convert(written, type(outcome.settings)) == outcome.settings


def test_a_dry_run_says_what_would_be_moved(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "robot", "--config", "simulated", "--dry-run", "--share", "0.4"]) == 0
    told = capsys.readouterr().out
    assert "up to 2 mm either way (40% of controller.limits.displacement_mm)" in told
    assert "nothing has moved" in told
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("share", ["1.2", "0.001"])
def test_a_share_beyond_the_limits_or_too_small_to_tell_anything_is_an_error(capsys, share):
    assert main(["calibrate", "robot", "--config", "simulated", "--share", share]) == 2
    assert f"--share {share}: allowed are 0.2 to 1" in capsys.readouterr().err


def test_the_stage_goes_where_there_is_room():
    settings = read_bench("simulated").settings.controller
    assert reach(settings, 0.5, 3.0).stage_mm == (3.0, 8.0)
    assert reach(settings, 0.5, 38.0).stage_mm == (38.0, 33.0)
    assert reach(settings, 0.5, None).stage_mm == ()


def test_figures_are_json(identified):
    *_, outcome = identified
    assert json.loads(msgspec.json.encode(outcome.foreseen))["nodes"][1]["name"] == "tip"
