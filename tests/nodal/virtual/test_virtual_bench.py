"""The bench in virtual time: it repeats itself to the last bit, and what happens to it is seen."""

import msgspec
import numpy as np
import pytest

from benchmarks.control.paths import CIRCLE, point
from benchmarks.control.robots import BENCH_ROBOT, OTHER_ROBOTS
from nodal.virtual.bench import VirtualBench
from nodal.virtual.errors import VirtualBenchError
from nodal.virtual.plant import Plant
from nodal.virtual.random_bench import random_bench

replace = msgspec.structs.replace


def begun(settings):
    bench = VirtualBench(settings, BENCH_ROBOT.controller, BENCH_ROBOT.robot)
    first = bench.run(0.5)[0]
    bench.do("home")
    return first, bench.run(1.0)[0]


def moved_mm(bench, duration_s):
    """How far the tip goes beside where a twin goes to which nothing happens."""
    return bench.run(duration_s)[0].node_mm[-1, -1]


def test_the_same_seed_gives_the_same_bytes():
    settings = random_bench(3)
    runs = [b"".join(samples.to_bytes() for samples in begun(settings)) for _ in range(2)]
    assert runs[0] == runs[1]
    other = b"".join(samples.to_bytes() for samples in begun(replace(settings, seed=4)))
    assert runs[0] != other


def test_a_copy_goes_on_as_the_bench_itself_does(tracking):
    twin = tracking.copy()
    assert tracking.run(0.5)[0].to_bytes() == twin.run(0.5)[0].to_bytes()


def test_nothing_moves_before_it_is_asked_to(homed_once):
    bench = VirtualBench(BENCH_ROBOT.bench, BENCH_ROBOT.controller, BENCH_ROBOT.robot)
    samples, _ = bench.run(1.0)
    assert set(samples.mode) == {"idle"}
    assert not samples.torque.any()
    assert np.isnan(samples.command_mm).all()
    np.testing.assert_allclose(
        samples.node_mm, np.broadcast_to(samples.node_mm[0], samples.node_mm.shape), atol=1e-3
    )


def test_homing_ends_straight_and_the_circle_is_followed(homed):
    tip = homed.run(0.0)[0].node_mm[0, -1]
    assert np.hypot(*tip[:2]) < 1.5
    assert homed.target(CIRCLE).accepted
    assert homed.do("arm").accepted
    homed.run(4.0)
    samples, _ = homed.run(3.0)
    assert set(samples.mode) == {"tracking"}
    assert np.sqrt((samples.error_mm("tip") ** 2).mean()) < 0.8
    assert np.isnan(samples.error_mm("middle")).all()


def test_commands_are_sampled_in_every_cycle(tracking):
    samples, _ = tracking.run(0.3)
    assert samples.command_mm.shape == (20, 3, 5)
    assert np.isfinite(samples.command_mm).all()
    np.testing.assert_allclose(np.diff(samples.now_s), 0.015)


def test_what_is_refused_is_answered(homed):
    reply = homed.target(point((0.0, 0.0, 300.0)))
    assert not reply.accepted
    assert "tip" in reply.reason


def test_homing_that_fails_says_why(homed):
    homed.seeing.lost = True
    homed.run(0.5)
    with pytest.raises(VirtualBenchError, match="no trusted shape"):
        homed.home()


@pytest.mark.parametrize(
    "happens",
    [
        lambda bench: bench.plant.robot.push([0.3, 0.0, 0.0]),
        lambda bench: bench.plant.robot.slip([0.5, -0.5] + [0.0] * 6),
        lambda bench: bench.plant.robot.rebuild(replace(bench.settings.robot, tip_payload_g=60.0)),
        lambda bench: bench.plant.jammed.update(range(4)),
    ],
    ids=["push", "slip", "payload", "jam"],
)
def test_what_happens_in_the_middle_of_a_run_moves_the_robot(tracking, happens):
    twin = tracking.copy()
    happens(tracking)
    assert np.linalg.norm(moved_mm(tracking, 0.3) - moved_mm(twin, 0.3)) > 0.05


def test_a_larger_pulley_moves_the_robot_further():
    def tip_x(*gain):
        settings = replace(BENCH_ROBOT.bench, servos=replace(BENCH_ROBOT.bench.servos, gain=gain))
        plant = Plant(settings)
        for _ in range(40):
            plant.servos[0].motor.position_rad = 0.6
            plant.follow(0.05)
        return plant.state.shape.centreline_mm[-1, 0]

    assert tip_x(1.3, 1.0, 1.0, 1.0, 1.0) > 1.2 * tip_x() > 10.0
    with pytest.raises(VirtualBenchError, match="5 axes"):
        tip_x(1.0)


@pytest.mark.parametrize("robot", OTHER_ROBOTS, ids=lambda robot: robot.name)
def test_other_robots_stand_on_the_bench(robot):
    bench = VirtualBench(random_bench(1, robot.bench), robot.controller, robot.robot)
    bench.run(0.2)
    assert bench.do("home").accepted
    samples, _ = bench.run(0.1)
    assert samples.torque.all()
    assert samples.command_mm.shape[2] == len(bench.plant.servos)


def test_random_benches_differ_and_repeat():
    assert random_bench(5) == random_bench(5)
    assert random_bench(5) != random_bench(6)
    gains = np.array([random_bench(seed).servos.gain for seed in range(50)])
    assert (np.abs(gains[:, :-1] - 1) <= 0.1).all()
    assert gains[:, :-1].std() > 0.03
