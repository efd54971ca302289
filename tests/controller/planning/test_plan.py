"""Ways between shapes: clear along the whole body, within travels and rates, the same every time."""

import numpy as np
import pytest

from controller.errors import NoWayError, TooCloseError
from controller.path import along
from controller.planning.plan import plan, present_shape
from controller.planning.solving import Wanted, missed_mm, solve_path
from controller.planning.space import Space
from controller.planning.timing import Timing
from controller.regions import Sphere
from messaging.control import Target

ARCS = {"middle": 40.0, "tip": 80.0}
BEHIND_THE_LAMP = (35.0, 0.0, 60.0)


def target_of(places_mm, time_s=(0.0,), *, repeat=False):
    return Target(
        name="place",
        node_names=("tip",),
        weights=[2.0],
        time_s=time_s,
        position_mm=np.reshape(places_mm, (-1, 1, 3)),
        repeat=repeat,
    )


def circle(turns=24):
    turn = np.linspace(0, 2 * np.pi, turns + 1)
    places = np.stack([15 * np.cos(turn), 15 * np.sin(turn), np.full_like(turn, 90.0)], axis=-1)
    places[-1] = places[0]
    return target_of(places, turn / (2 * np.pi) * 12.0, repeat=True)


@pytest.fixture
def scene(stand_ins):
    settings = stand_ins["settings"](forbidden=(stand_ins["LAMP"], stand_ins["WALL"]))
    plant = stand_ins["plant"](settings)
    return settings, plant, Space(plant)


def bodies(space, planned, moments):
    """(k, C) the configurations that a planned target leads through, by solving for all of its nodal points."""
    path = along(planned, moments)
    arcs = np.array([ARCS[name] for name in planned.node_names])
    wanted = Wanted(place_mm=path.node_mm, arc_mm=arcs, weights=planned.weights)
    solved = solve_path(space, wanted, near_enough_mm=0.2)
    assert missed_mm(space, wanted, solved).max() < 0.5
    return solved


@pytest.mark.parametrize("timing", Timing)
def test_a_way_round_a_region_keeps_the_body_clear_within_speeds_and_rates(scene, timing):
    settings, plant, space = scene
    present = space.straight(0.0)
    found = plan(target_of(BEHIND_THE_LAMP), ARCS, present, plant, settings, timing=timing)
    assert found.way.samples > 0, "the straight way leads through the lamp"
    assert found.spare_mm > 0
    assert (space.spare_mm(found.way.configurations) > 0).all()

    planned = found.target
    assert planned.node_names == ("tip", "middle")
    assert planned.weights[0] == 2
    moments = np.linspace(0, planned.time_s[-1], 200)
    path = along(planned, moments)
    np.testing.assert_allclose(path.node_mm[0, 0], [0, 0, 80], atol=1e-6)
    np.testing.assert_allclose(path.node_mm[-1, 0], BEHIND_THE_LAMP, atol=1e-9)
    np.testing.assert_allclose(path.velocity_mm_s[[0, -1]], 0, atol=0.5)
    assert np.linalg.norm(path.velocity_mm_s, axis=-1).max() <= settings.maximum_node_speed_mm_s
    led = bodies(space, planned, moments)
    assert space.spare_mm(led).min() > -0.2
    rates = np.abs(np.diff(space.commands(found.way.configurations), axis=0))
    assert (rates.max(axis=0) <= plant.limits.rate_mm_s).all()


def test_the_same_seed_finds_the_same_way_and_another_a_good_one_too(scene):
    settings, plant, space = scene
    ways = [
        plan(target_of(BEHIND_THE_LAMP), ARCS, space.straight(0.0), plant, settings, seed=seed)
        for seed in (3, 3, 4)
    ]
    assert ways[0].target.to_bytes() == ways[1].target.to_bytes()
    assert ways[0].target.to_bytes() != ways[2].target.to_bytes()


def test_without_regions_the_way_is_straight_and_a_repeating_path_follows_it_smoothly(stand_ins):
    settings = stand_ins["settings"]()
    plant = stand_ins["plant"](settings)
    found = plan(circle(), ARCS, Space(plant).straight(5.0), plant, settings)
    planned = found.target
    assert found.way.samples == 0
    assert planned.repeat
    assert planned.repeat_from_s > found.way_s
    assert planned.time_s[-1] - planned.repeat_from_s == pytest.approx(12.0)
    moments = np.linspace(0, planned.time_s[-1] + 12.0, 3000)
    path = along(planned, moments)
    turning = path.node_mm[moments > found.way_s, 0]
    assert np.abs(np.linalg.norm(turning[:, :2], axis=1) - 15).max() < 0.2
    jumps = np.abs(np.diff(path.velocity_mm_s[:, 0], axis=0)).max()
    assert jumps < 1.0


def test_a_path_that_ends_follows_its_way_with_its_own_timing(scene):
    settings, plant, space = scene
    asked = target_of([(10, 0, 88), (0, 10, 90), (-10, 0, 88)], [0.0, 2.0, 5.0])
    found = plan(asked, ARCS, space.straight(5.0), plant, settings)
    planned = found.target
    lasts_s = planned.time_s[-1] - found.way_s
    assert lasts_s == pytest.approx(5.0 + 0.15)
    tip = along(planned, found.way_s + 0.15 + np.array([2.0, 5.0])).node_mm[:, 0]
    np.testing.assert_allclose(tip, asked.position_mm[1:, 0], atol=1e-6)


@pytest.mark.parametrize(("single", "stage"), [(True, True), (False, False), (True, False)])
@pytest.mark.parametrize("sections", [1, 3])
def test_other_robots_find_their_way_too(stand_ins, random, sections, single, stage):
    settings = stand_ins["settings"](sections, single=single, forbidden=(stand_ins["LAMP"],))
    plant = stand_ins["plant"](settings, stage=stage)
    space = Space(plant)
    free = [c for c in (space.random(random) for _ in range(100)) if space.spare_mm(c) > 1.0]
    places, _ = space.nodes_and_jacobian(free[0], np.array([80.0]))
    found = plan(target_of(places[0]), {"tip": 80.0}, free[1], plant, settings)
    assert (space.spare_mm(found.way.configurations) > 0).all()
    commands = space.commands(found.way.configurations)
    assert (commands <= plant.limits.high_mm + 1e-9).all()
    assert (commands >= plant.limits.low_mm - 1e-9).all()


def test_why_there_is_no_way_is_said(scene, stand_ins):
    settings, plant, space = scene
    with pytest.raises(
        TooCloseError, match=r"at 0 s the robot would be 6.0 mm inside region lamp 80 mm along"
    ):
        plan(target_of((22.0, 0.0, 62.0)), ARCS, space.straight(0.0), plant, settings)
    inside = Wanted(place_mm=np.array([[[20.0, 0.0, 70.0]]]), arc_mm=np.array([80.0]), weights=np.ones(1))
    present = solve_path(Space(stand_ins["plant"](stand_ins["settings"]())), inside, near_enough_mm=0.1)[0]
    with pytest.raises(
        NoWayError, match=r"no way begins at the present shape: the robot would be .* region lamp"
    ):
        plan(target_of((0.0, 0.0, 90.0)), ARCS, present, plant, settings)


def test_no_way_is_said_after_so_many_samples(stand_ins):
    """A ring of balls round the axis, without gaps between them: the robot cannot get to their other side."""
    ring = tuple(
        Sphere(name=f"ball {n}", centre_mm=(30 * np.cos(a), 30 * np.sin(a), 66.0), radius_mm=12.0)
        for n, a in enumerate(np.linspace(0, 2 * np.pi, 13)[:-1])
    )
    settings = stand_ins["settings"](forbidden=ring, keep_clear_mm=3.0)
    plant = stand_ins["plant"](settings, stage=False)
    with pytest.raises(
        NoWayError, match=r"no way to it was found in 40 samples; regions ball 0, .*, ball 11"
    ):
        plan(target_of((56.0, 0.0, 45.0)), ARCS, Space(plant).straight(0.0), plant, settings, most_samples=40)


def test_the_present_shape_is_fitted(any_space, random):
    shape, arc = any_space.random(random) / 2, any_space.plant.body_arc_mm
    if any_space.kinematics.stage:
        shape[-1] = 12.0
    places, _ = any_space.nodes_and_jacobian(shape, arc)
    fitted = present_shape(any_space, places, arc, 12.0)
    again, _ = any_space.nodes_and_jacobian(fitted, arc)
    assert np.linalg.norm(again - places, axis=-1).max() < 0.1
