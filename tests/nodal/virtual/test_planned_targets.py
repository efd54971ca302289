"""A planned target on the virtual bench: a robot that the model does not describe well goes round what is in its way."""

import msgspec
import numpy as np

from benchmarks.control.robots import BENCH_ROBOT
from controller.planning.plan import plan
from controller.planning.space import Space
from controller.plant import Plant
from controller.regions import Sphere
from nodal import targets
from nodal.targets.present import Present
from nodal.virtual.bench import VirtualBench

BALL = Sphere(name="ball", centre_mm=(13.0, 13.0, 81.0), radius_mm=2.0)
GOAL_MM = (22.0, 22.0, 76.0)


def test_a_planned_target_leads_the_body_round_a_ball_and_arrives():
    settings = msgspec.structs.replace(BENCH_ROBOT.controller, forbidden=(BALL,))
    bench = VirtualBench(BENCH_ROBOT.bench, settings, BENCH_ROBOT.robot)
    bench.home()
    plant = Plant.of(settings, BENCH_ROBOT.robot)
    present = Present.of(bench.state.seen.shape, None, Space(plant))
    target = targets.points({"tip": GOAL_MM}, {})

    refused = bench.target(target)
    assert not refused.accepted
    assert "on the straight way to its beginning" in refused.reason

    found = plan(target, present.node_arc_mm, present.configuration, plant, settings)
    assert found.way.samples > 0
    assert bench.target(found.target).accepted
    assert bench.do("arm").accepted
    samples, _ = bench.run(found.way_s + 2.5)
    assert set(samples.mode) == {"tracking"}
    assert bench.state.progress == 1
    away = np.linalg.norm(samples.node_mm - BALL.centre_mm, axis=-1) - BALL.radius_mm
    assert away.min() > settings.keep_clear_mm - 1
    tip = samples.node_names.index("tip")
    assert np.linalg.norm(samples.node_mm[-1, tip] - GOAL_MM) < 0.3
