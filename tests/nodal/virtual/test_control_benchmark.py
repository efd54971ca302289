"""The figures, runs and faults of `python -m benchmarks.control`."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from benchmarks.control.__main__ import main
from benchmarks.control.faults import FAULTS, consequence, tracking_bench
from benchmarks.control.figures import stepped, sways, tracked
from benchmarks.control.paths import REST_MM
from benchmarks.control.robots import BENCH_ROBOT, OTHER_ROBOTS
from benchmarks.control.running import OPEN_LOOP, Job, controlled_by, run
from benchmarks.control.scenarios import SCENARIOS, gains, mixed_gains, tuned
from controller.plant import Plant
from controller.settings import ControllerSettings
from nodal.virtual.random_bench import random_bench
from nodal.virtual.samples import Samples

PERIOD_S, SEEDS = 0.015, (2, 3)
LAW = ControllerSettings().law
LIMITS = Plant.of(BENCH_ROBOT.controller, BENCH_ROBOT.robot).limits


def samples_of(tip_mm, desired_mm, command_mm=None):
    count = len(tip_mm)
    return Samples(
        now_s=PERIOD_S * np.arange(count),
        desired_mm=np.asarray(desired_mm, dtype=float)[:, None],
        node_mm=np.asarray(tip_mm, dtype=float)[:, None],
        command_mm=np.zeros((count, 3, 5)) if command_mm is None else command_mm,
        current_ma=np.zeros((count, 5)),
        tension_N=np.ones((count, 8)),
        torque=np.ones(count, dtype=bool),
        mode=("tracking",) * count,
        reason=("",) * count,
        node_names=("tip",),
    )


def still(count=400):
    return np.zeros((count, 3))


def test_a_step_is_timed_until_it_stays_near_its_goal():
    way = np.clip(np.linspace(0, 2, 201), 0, 1)[:, None] * [10.0, 0, 0]
    way[120] = [11.0, 0, 0]
    settle_s, overshoot = stepped(samples_of(way, way), np.zeros(3), np.array([10.0, 0, 0]))
    assert settle_s == pytest.approx(120 * PERIOD_S)
    assert overshoot == pytest.approx(10.0)
    settle_s, _ = stepped(samples_of(way[:90], way[:90]), np.zeros(3), np.array([10.0, 0, 0]))
    assert settle_s == np.inf


def test_errors_count_only_while_the_tip_is_led():
    desired = np.tile([0.3, 0.4, 0.0], (400, 1))
    desired[:100] = np.nan
    figures = tracked(samples_of(still(), desired), LIMITS)
    assert (figures.rms_mm, figures.worst_mm, figures.held) == pytest.approx((0.5, 0.5, 0.25))
    assert not figures.unstable
    assert figures.violations == 0


def test_commands_beyond_travel_or_rate_are_counted():
    command = np.zeros((400, 3, 5))
    command[10, 1, 0] = LIMITS.high_mm[0] + 0.1
    violations = tracked(samples_of(still(), still(), command), LIMITS).violations
    assert violations == 3  # one place beyond the travel, and two steps to and from it that are too fast


def test_a_sway_is_told_from_slow_motion():
    time_s = PERIOD_S * np.arange(400)
    slow = np.column_stack([15 * np.cos(0.2 * np.pi * time_s), 15 * np.sin(0.2 * np.pi * time_s), 0 * time_s])
    assert not sways(samples_of(slow, slow))
    shaken = slow + np.column_stack([np.sin(6 * np.pi * time_s), 0 * time_s, 0 * time_s])
    assert sways(samples_of(shaken, slow))


def test_late_and_rare_shapes_are_trusted_on_their_benches():
    for scenario in SCENARIOS:
        bench = scenario.build(random_bench(1, scenario.robot.bench))
        sensing = tuned(scenario.robot.controller, bench).sensing
        assert sensing.maximum_age_s > bench.shape.delay_s + bench.shape.jitter_s + bench.robot_step_s
        assert sensing.timeout_s > 1.5 / bench.shape.rate_hz
        assert sensing.timeout_s == scenario.robot.controller.sensing.timeout_s or bench.shape.rate_hz < 30


@pytest.fixture(scope="module")
def figures_of():
    """Of a run on half a turn, or at one place; none is run twice."""

    @cache
    def run_once(scenario, *, law=LAW, seed=2):
        return run(Job(seed=seed, law=law, scenario=scenario)).figures

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("benchmarks.control.scenarios.TURN_S", 5.0)
        patch.setattr("benchmarks.control.scenarios.REST_MM", REST_MM[:1])
        yield run_once


def test_the_yardsticks_are_met(figures_of):
    circles = [figures_of("circle", seed=seed) for seed in SEEDS]
    steps = [figures_of("step 10 mm", seed=seed) for seed in SEEDS]
    still = figures_of("steady state")
    assert np.median([circle.rms_mm for circle in circles]) <= 0.4
    assert still.rms_mm <= 0.1
    assert max(step.settle_s for step in steps) <= 1.0
    assert max(step.overshoot_percent for step in steps) <= 10.0
    for figures in (*circles, *steps, still):
        assert (figures.violations, figures.unstable, figures.fault) == (0, False, "")


def test_the_law_beats_open_loop_on_a_bench_that_no_model_fits(figures_of):
    seen, blind = figures_of("circle"), figures_of("circle", law=OPEN_LOOP)
    assert blind.rms_mm > 0.05 * BENCH_ROBOT.robot.length_mm
    assert seen.rms_mm < blind.rms_mm / 8


def test_gains_are_wrong_on_every_axis_and_each_by_its_own_sign():
    for robot in (BENCH_ROBOT, OTHER_ROBOTS[-2]):
        drawn = random_bench(3, robot.bench)
        gain, mixed = ([*build(drawn).servos.gain] for build in (gains(1.3), mixed_gains))
        np.testing.assert_allclose(np.divide(gain, drawn.servos.gain), 1.3)
        assert set(np.divide(mixed, drawn.servos.gain).round(9)) == {0.7, 1.3}
        assert len(gain) == len(mixed) == robot.robot.stage + 4


def test_a_law_is_tuned(capsys, monkeypatch):
    told = []
    monkeypatch.setattr("benchmarks.control.__main__.run_all", lambda jobs, _: told.extend(jobs) or ())
    words = ["--laws", "model_free", "--benches", "1", "--scenarios", "circle"]
    assert main([*words, "--tuning", "feedback_per_s=4", "--tuning", "name=slow"]) == 0
    assert [job.tuning for job in told] == [{"feedback_per_s": 4, "name": "slow"}, {}]
    assert controlled_by("model_free", told[0].tuning, ControllerSettings()).tuning["feedback_per_s"] == 4


@pytest.fixture(scope="module")
def tracking():
    return tracking_bench()


@pytest.mark.parametrize(
    ("name", "mode", "within_s"),
    [
        ("operator stop", "idle", 0.01),
        ("sensing refuses", "fault", 0.15),
        ("servo silent", "fault", 0.07),
        ("servo overload", "fault", 0.01),
        ("servo restarts", "fault", 0.07),
        ("stage is forced", "fault", 0.2),
        ("law answers nan", "fault", 0.01),
    ],
)
def test_faults_end_the_motion(tracking, name, mode, within_s):
    fault = next(fault for fault in FAULTS if fault.name == name)
    found = consequence(tracking.copy(), fault, watched_s=1.2)
    assert found.mode == mode
    assert found.safe_s <= within_s
    assert found.driven_mm < 2.0
    assert found.after_mm < 2.0


def test_the_command_prints_a_row_and_the_yardsticks(capsys, monkeypatch):
    short = dataclasses.replace(SCENARIOS[0], play=lambda bench, limits: tracked(bench.run(0.5)[0], limits))
    monkeypatch.setattr("benchmarks.control.__main__.SCENARIOS", (short,))
    monkeypatch.setattr("benchmarks.control.running.SCENARIOS", (short,))
    law = ControllerSettings().law
    assert main(["--benches", "1", "--laws", law, "--jobs", "1", "--scenarios", "circle"]) == 0
    printed = capsys.readouterr().out
    assert f"circle          {law}" in printed
    assert "open_loop" in printed
    assert "x faster than real time" in printed


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scenarios", "hurricane"], "no scenario hurricane"),
        (["--laws", "magic"], "no law or file magic"),
        (["--benches", "0"], "from 1"),
        (["--tuning", "a=1"], "--tuning is of one law"),
        (["--laws", "model_free", "--tuning", "a"], "is not KEY=VALUE"),
    ],
)
def test_what_there_is_not_is_refused_by_name(words, said, capsys):
    with pytest.raises(SystemExit):
        main(words)
    assert said in capsys.readouterr().err


def test_help_names_every_scenario(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    printed = " ".join(capsys.readouterr().out.split())
    assert all(scenario.name in printed for scenario in SCENARIOS)
