"""Finding slack: on a paper robot whose play is known, and on the simulated robot's mechanics; and what is no robot at all."""

import msgspec
import numpy as np
import pytest

from controller.settings import ControllerSettings, HomingSettings, SectionTendons, SensingSettings
from messaging.settings import RobotSettings
from nodal.virtual.bench import VirtualBench
from nodal.virtual.random_bench import random_bench
from nodal.virtual.settings import ShapeSettings, VirtualBenchSettings

PERIOD_S = 0.005
SINGLE = ControllerSettings(sections=(SectionTendons(tendon_angle_deg=(0.0, 120.0, 240.0)),) * 2)


@pytest.fixture
def bench_of(stand_ins):
    """A bench around a paper robot: its settings, and what is wrong with the robot."""

    def make(*, settings=None, **robot):
        settings = settings or ControllerSettings()
        paper = stand_ins["PaperRobot"](settings.kinematics(stand_ins["ROBOT"]), **robot)
        return stand_ins["VirtualBench"](paper, settings)

    return make


def homing(bench, at_most_s=30.0):
    """The cycles from `home` until homing ends."""
    bench.run(0.2)
    assert bench.do("home").accepted
    moments = []
    while bench.state.mode == "homing" and len(moments) * PERIOD_S < at_most_s:
        moments.append(bench.cycle(()))
    return moments


@pytest.mark.parametrize("play_mm", [0.0, 0.15, 0.3, 0.6])
def test_the_play_of_every_pair_is_found_and_the_stage_has_none(bench_of, play_mm):
    bench = bench_of(play_mm=play_mm)
    homing(bench)
    assert bench.state.mode == "ready"
    np.testing.assert_allclose(bench.state.lost_motion_mm[:4], play_mm, atol=0.06)
    assert bench.state.supervision.reason.startswith("homed; lost motion 0.")
    assert bench.state.supervision.reason.count(",") == 3
    assert np.isnan(bench.state.lost_motion_mm[4])


def test_an_axis_is_left_in_the_middle_of_its_play(bench_of):
    bench = bench_of(play_mm=0.6)
    moments = homing(bench)
    searching = [moment for moment in moments if moment.state.search is not None]
    renamed = next(moment for moment in moments if moment.state.search is None)
    assert renamed.outputs.zero_mm is not None
    left_mm = np.abs(searching[-1].state.command_mm[:4] - bench_middle(searching))
    assert left_mm.max() < 0.1


def bench_middle(searching):
    """(4,) where commands turned round, in the middle, but for what the robot had to follow to be seen."""
    commands = np.array([moment.state.command_mm[:4] for moment in searching])
    return (commands.max(axis=0) + commands.min(axis=0)) / 2


def test_the_search_is_slow_short_and_says_what_it_does(bench_of):
    settings = HomingSettings(probe_mm_s=1.0, search_mm=1.5)
    bench = bench_of(settings=ControllerSettings(homing=settings))
    moments = [moment for moment in homing(bench) if moment.state.search is not None]
    commands = np.array([moment.state.command_mm for moment in moments])
    assert np.abs(np.diff(commands, axis=0)).max() <= settings.probe_mm_s * PERIOD_S * 1.001
    assert np.abs(commands).max() <= settings.search_mm
    assert {moment.outputs.reason for moment in moments} == {
        f"finding the slack of tendon {number}" for number in range(1, 5)
    }


def test_without_the_search_the_robot_is_led_straight_at_once(bench_of):
    bench = bench_of(settings=ControllerSettings(homing=HomingSettings(find_slack=False)))
    moments = homing(bench)
    assert bench.state.mode == "ready"
    assert moments[0].state.task is not None
    assert moments[0].outputs.reason == "leading the robot straight"
    assert bench.state.supervision.reason == "homed"
    assert np.isnan(bench.state.lost_motion_mm).all()


@pytest.mark.parametrize(
    ("gain", "code", "words"),
    [
        (np.array([0.8, 0.0, 0.8, 0.8]), "tendon_slack", "tendon 2 was moved by 3 mm, and no nodal point moved by 0.5"),
        (np.array([0.8, 0.8, -0.8, 0.8]), "wrong_way", "tendon 3 was pulled, and the robot went the opposite way"),
    ],
    ids=["snapped", "signed wrong"],
)  # fmt: skip
def test_what_does_not_answer_as_it_should_is_named(bench_of, gain, code, words):
    bench = bench_of(gain=gain)
    fault = homing(bench)[-1]
    assert fault.state.supervision.fault.code == code
    assert words in fault.outputs.reason
    assert fault.outputs.release
    assert not bench.servos.torque


def test_swapped_tendons_go_sideways(bench_of):
    bench = bench_of()
    straight = bench.robot.move
    bench.robot.move = lambda command_mm, dt_s: straight(command_mm[[1, 0, 3, 2, 4]], dt_s)
    assert "tendon 1 was pulled, and the robot went sideways" in homing(bench)[-1].outputs.reason


def test_a_robot_that_keeps_moving_is_not_probed(bench_of):
    bench = bench_of(settings=ControllerSettings(homing=HomingSettings(timeout_s=1.0)))
    still = bench.robot.move
    bench.robot.move = lambda command_mm, dt_s: still(command_mm, dt_s) + 20 * (bench.now_s - 100.0)
    fault = homing(bench)[-1]
    assert "does not come to rest within 1 s" in fault.outputs.reason
    assert fault.state.supervision.fault.unit == "s"


def test_current_ends_a_stroke_that_no_camera_sees(bench_of):
    bench = bench_of(gain=np.array([0.8, 0.8, 0.8, 0.0]), offset_mm=(0.1, 0.1, -0.1))
    bench.servos.pull_ma = lambda pulled_mm: (
        900 * np.clip(pulled_mm - 0.3, 0, None) + 900 * np.clip(pulled_mm + 0.3, None, 0)
    )
    homing(bench)
    assert bench.state.mode == "ready", bench.state.supervision
    assert np.isnan(bench.state.lost_motion_mm[3])
    assert np.isfinite(bench.state.lost_motion_mm[:3]).all()


def test_single_tendons_are_tightened_one_after_the_other(bench_of):
    taut_mm = np.array([0.5, 0.2, 1.0, 0.3, 0.7, 0.4, np.inf])
    bench = bench_of(settings=SINGLE, gain=0.0, offset_mm=(0.0, 0.0, 0.0))
    bench.servos.pull_ma = lambda pulled_mm: 400 * np.clip(pulled_mm - taut_mm, 0, None)
    moments = [moment for moment in homing(bench) if moment.state.search is not None]
    tightened_mm = moments[-1].state.command_mm[:6]
    np.testing.assert_allclose(tightened_mm, taut_mm[:6] + 80 / 400, atol=0.1)
    assert any(moment.outputs.reason == "tightening tendon 4" for moment in moments)


def test_a_single_tendon_that_never_pulls_is_named(bench_of):
    bench = bench_of(settings=SINGLE, gain=0.0)
    fault = homing(bench)[-1]
    assert "tendon 1 was moved by 3 mm" in fault.outputs.reason
    assert "80 mA" in fault.outputs.reason
    assert fault.state.supervision.fault.code == "tendon_slack"


def test_the_cameras_say_as_well_that_a_single_tendon_is_tight(bench_of):
    """No current ever rises, as with much friction in the servo."""
    moments = [moment for moment in homing(bench_of(settings=SINGLE, play_mm=0.0)) if moment.state.search]
    tightened_mm = moments[-1].state.command_mm[:6]
    assert (tightened_mm > 0.1).all()
    assert (tightened_mm < 1.0).all()


@pytest.mark.parametrize(
    "let_out_ma",
    [lambda out_mm: -200.0 * out_mm, lambda out_mm: np.minimum(400.0 * out_mm - 500.0, 0.0)],
    ids=["a current that falls", "a load that ends"],
)
def test_a_tendon_that_is_let_out_is_not_tight(bench_of, let_out_ma):
    """The second is wound the wrong way round, and no camera sees any motion."""
    bench = bench_of(settings=SINGLE, gain=0.0)
    bench.servos.pull_ma = lambda pulled_mm: np.where(
        np.arange(7) == 1, let_out_ma(pulled_mm), 400 * pulled_mm
    )
    fault = homing(bench)[-1]
    assert fault.state.supervision.fault.code == "tendon_slack"
    assert "tendon 2 was moved by 3 mm" in fault.outputs.reason


@pytest.mark.parametrize(
    ("connected", "how"),
    [([0, 2, 1, 3, 4, 5, 6], "the opposite way"), ([0, 4, 2, 3, 1, 5, 6], "sideways")],
    ids=["of one section", "of two sections"],
)
@pytest.mark.parametrize("ma_per_mm", [100, 500], ids=["current rises last", "current rises first"])
def test_single_tendons_that_are_swapped_pull_elsewhere(bench_of, connected, how, ma_per_mm):
    """However little the robot has moved by the time that the current has risen as it should."""
    angles_deg = (0.0, 120.0, 240.0), (90.0, 210.0, 330.0)
    settings = ControllerSettings(sections=tuple(SectionTendons(tendon_angle_deg=a) for a in angles_deg))
    bench = bench_of(settings=settings, play_mm=0.0)
    straight = bench.robot.move
    bench.robot.move = lambda command_mm, dt_s: straight(command_mm[connected], dt_s)
    bench.servos.pull_ma = lambda pulled_mm: ma_per_mm * np.clip(pulled_mm, 0, None)
    fault = homing(bench)[-1]
    assert f"tendon 2 was pulled, and the robot went {how}" in fault.outputs.reason
    assert fault.state.supervision.fault.code == "wrong_way"


def test_a_pair_whose_current_rises_while_the_robot_goes_sideways_is_named(bench_of):
    bench = bench_of(play_mm=0.0)
    straight = bench.robot.move
    bench.robot.move = lambda command_mm, dt_s: straight(command_mm[[1, 0, 3, 2, 4]], dt_s)
    bench.servos.pull_ma = lambda pulled_mm: 300 * pulled_mm
    assert "tendon 1 was pulled, and the robot went sideways" in homing(bench)[-1].outputs.reason


SLOW = ShapeSettings(rate_hz=10.0, delay_s=0.15, dropped=0.2)


@pytest.mark.parametrize(
    "settings",
    [VirtualBenchSettings(), msgspec.structs.replace(random_bench(2), shape=SLOW)],
    ids=["nominal", "another robot, 10 Hz, 150 ms late, every fifth shape lost"],
)
def test_the_simulated_robot_is_homed_within_15_s_and_its_lost_motion_found(settings):
    """Play of 0.05 to 0.25 mm, and friction that swallows as much again and more."""
    sensing = SensingSettings(timeout_s=0.4, maximum_age_s=0.4)
    bench = VirtualBench(
        settings, ControllerSettings(sensing=sensing), RobotSettings(section_length_mm=(40.0, 40.0))
    )
    began_s = bench.now_s
    bench.home(within_s=15.0)
    assert bench.now_s - began_s < 15.0
    lost_mm = bench.state.lost_motion_mm[:4]
    assert (lost_mm > 0.15).all()
    assert (lost_mm < 0.75).all()
    assert np.abs(bench.plant.state.shape.centreline_mm[:, :2]).max() < 1.0
