"""A robot that is led to be identified, on a bench in virtual time: what is found, what is refused, and what is kept."""

import json
import tomllib

import msgspec
import numpy as np
import pytest

from calibration.robot_plan import Reach, planned
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
from nodal.calibrate.robot.results import axes_found, identify
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
        self.leader = Leader(VirtualHand(self.bench), self.settings, 2, self.turned)
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


@pytest.fixture(scope="module")
def identified():
    led = Led(homing=HomingSettings(find_slack=False))
    within = Reach(tendon_mm=3.0, stage_mm=(0.0, 4.0))
    plan = planned(led.kinematics.command_of_coordinates[:2, :2], np.ones(2, bool), within, 8, 4)
    told = []
    seen = experiment(led.leader, plan, told.append)
    led.leader.let_go()
    outcome = identify(seen, led.settings, led.kinematics, led.leader.node_names, "today")
    return led, seen, outcome, told


def test_moves_that_nobody_fitted_are_foreseen_several_times_better_than_by_the_drawing(identified):
    led, seen, outcome, _ = identified
    foreseen = outcome.foreseen
    assert foreseen.poses == seen.held_out == 4
    assert foreseen.before_mm > 0.05 * 40
    assert foreseen.after_mm < foreseen.before_mm / 2.5
    assert [node.name for node in foreseen.nodes] == ["middle", "tip"]
    assert led.bench.state.mode == "idle"


def test_gains_of_axes_and_stage_come_out_in_their_order(identified):
    led, seen, outcome, _ = identified
    x, y = axes_found(outcome, seen, led.kinematics, NAMES)
    assert x.gain / y.gain == pytest.approx(1.1 / 0.8, abs=0.15)
    assert outcome.settings.stage_gain[0] == pytest.approx(0.03, abs=0.02)
    assert 0.2 < x.lost_motion_mm < 0.9
    assert x.current_between_ways_ma is not None
    assert x.current_between_ways_ma > 10


def test_what_is_found_goes_into_the_bench_file_and_comes_out_the_same(identified, tmp_path):
    *_, outcome, _ = identified
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


def test_a_share_beyond_the_limits_is_an_error(capsys):
    assert main(["calibrate", "robot", "--config", "simulated", "--share", "1.2"]) == 2
    assert "--share 1.2: allowed is above 0 and up to 1" in capsys.readouterr().err


def test_the_stage_goes_where_there_is_room():
    settings = read_bench("simulated").settings.controller
    assert reach(settings, 0.5, 3.0).stage_mm == (3.0, 8.0)
    assert reach(settings, 0.5, 38.0).stage_mm == (38.0, 33.0)
    assert reach(settings, 0.5, None).stage_mm == ()


def test_figures_are_json(identified):
    *_, outcome, _ = identified
    assert json.loads(msgspec.json.encode(outcome.foreseen))["nodes"][1]["name"] == "tip"
