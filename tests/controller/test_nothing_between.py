"""Whatever a path is like, nothing that stands on it can be missed between the moments that are looked at."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.errors import TooCloseError, TooFastError, TooLongError, UnreachableError
from controller.path import along
from controller.planning.looks import look_along
from controller.planning.space import Space
from controller.plant import Plant
from controller.reachability import check_target
from controller.regions import HalfSpace, Sphere
from controller.settings import ControllerSettings, SectionTendons
from messaging.control import Target
from messaging.settings import RobotSettings

ARCS = {"tip": 80.0}
ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))
ONE_SECTION = RobotSettings(section_length_mm=(80.0,), stage=False)
FAR_WALL = HalfSpace(name="wall", point_mm=(0.0, -200.0, 0.0), normal=(0.0, 1.0, 0.0))
MIDDLE_MM = np.array([0.0, 0.0, 88.0])
ROWS = 2001
seeds = st.integers(0, 2**32 - 1)


def wandering(random, rows, *columns_mm):
    """(rows, columns) smooth and random, each column within so many mm of 0."""
    phase, turns = random.uniform(0, 2 * np.pi, (3, len(columns_mm))), random.uniform(0.5, 6, (3, 1))
    at = np.linspace(0, 2 * np.pi, rows)[:, None, None]
    return np.array(columns_mm) * np.sin(at * turns + phase).mean(axis=1)


def led(places_mm, *, repeat=False):
    """The tip through these places, slowly."""
    steps = np.abs(np.diff(places_mm, axis=0)).sum(axis=1)
    return Target(
        name="path",
        node_names=("tip",),
        weights=[1.0],
        time_s=np.append(0.0, np.cumsum(steps / 2 + 1e-3)),
        position_mm=np.reshape(places_mm, (-1, 1, 3)),
        repeat=repeat,
    )


def check(target, *regions, robot=ROBOT, start_mm=None, **others):
    settings_ = ControllerSettings(forbidden=regions, **others)
    check_target(target, ARCS, Plant.of(settings_, robot), settings_, start_mm=start_mm)


def ball(random, place_mm, spare_mm, keep_clear_mm):
    """One that this place is `spare_mm` farther away from than it must be."""
    radius, way = random.uniform(0.2, 2.0), random.normal(size=3)
    centre = place_mm + (radius + keep_clear_mm + spare_mm) * way / np.linalg.norm(way)
    return Sphere(name="ball", centre_mm=tuple(centre.tolist()), radius_mm=radius)


@settings(max_examples=60, deadline=None)
@given(seed=seeds, rows=st.sampled_from([4, 30, ROWS]), keep_clear_mm=st.sampled_from([0.0, 1.0, 5.0]))
def test_no_path_leads_the_tip_into_a_ball(seed, rows, keep_clear_mm):
    random = np.random.default_rng(seed)
    target = led(MIDDLE_MM + wandering(random, rows, 20.0, 20.0, 4.0))
    met = along(target, random.uniform(0, target.time_s[-1])).node_mm[0]
    deep = random.uniform(0.1, keep_clear_mm + 0.2)
    with pytest.raises(TooCloseError, match="region ball"):
        check(target, ball(random, met, -deep, keep_clear_mm), keep_clear_mm=keep_clear_mm)


@settings(max_examples=30, deadline=None)
@given(seed=seeds)
def test_no_straight_way_to_the_beginning_leads_the_tip_into_a_ball(seed):
    random = np.random.default_rng(seed)
    begin, start = [0, 0, 85] + random.uniform(-25, 25, (2, 3)) * [1, 1, 0.2]
    lamp = ball(random, start + random.uniform(0, 1) * (begin - start), -1.1, 1.0)
    with pytest.raises(TooCloseError, match="region ball"):
        check(led([begin]), lamp, start_mm=start[None], keep_clear_mm=1.0)


@settings(max_examples=30, deadline=None)
@given(seed=seeds, keep_clear_mm=st.sampled_from([2.0, 5.0]))
def test_no_path_leads_the_body_into_a_ball(seed, keep_clear_mm):
    """One section without a stage: for every place of the tip there is one shape, so it cannot lean out of the way."""
    random = np.random.default_rng(seed)
    section = (SectionTendons(pair_angle_deg=(0.0, 90.0)),)
    space = Space(Plant.of(ControllerSettings(sections=section), ONE_SECTION))
    shapes = space.within(np.array([3.0, 0.0]) + wandering(random, ROWS, 2.5, 5.0))
    tip, _ = space.nodes_and_jacobian(shapes, np.array([80.0]))
    body, _ = space.nodes_and_jacobian(shapes[random.integers(ROWS)], np.array([random.uniform(15, 75)]))
    met = ball(random, body[0], -0.6 * keep_clear_mm, keep_clear_mm)
    with pytest.raises(TooCloseError, match="region ball"):
        check(led(tip[:, 0]), met, robot=ONE_SECTION, sections=section, keep_clear_mm=keep_clear_mm)


@settings(max_examples=40, deadline=None)
@given(seed=seeds, beside=st.booleans())
def test_a_spike_out_of_reach_in_one_row_is_refused(seed, beside):
    random = np.random.default_rng(seed)
    places = MIDDLE_MM + wandering(random, ROWS, 10.0, 10.0, 2.0)
    row = random.integers(ROWS)
    # beyond the robot's length, or so near to its base that it cannot bend to there
    places[row] = [90.0, 0.0, 20.0] if beside else [1.0, 0.0, 45.0]
    for regions in ((), (FAR_WALL,)):
        with pytest.raises(UnreachableError, match="tip at"):
            check(led(places), *regions)


def test_a_path_that_is_too_long_says_how_long_it_may_be():
    rows = 3000
    places = MIDDLE_MM + np.array([[5.0 * (-1) ** n, 0, 0] for n in range(rows)])
    with pytest.raises(
        TooLongError, match=r"path: a way of 29990 mm, .* at most 5000 mm can be checked, so send it in parts"
    ):
        check(led(places), FAR_WALL)


@settings(max_examples=60, deadline=None)
@given(seed=seeds, rows=st.integers(1, 200), repeat=st.booleans())
def test_looks_are_no_farther_apart_than_they_are_said_to_be(seed, rows, repeat):
    random = np.random.default_rng(seed)
    places = random.uniform(-20, 20, (rows, 3))
    if repeat:
        places = np.concatenate([places, places[:1]])
    target = led(places, repeat=repeat)
    looks = look_along(target, ARCS, 2.5)
    fine = np.linspace(0, looks.time_s[-1], 20_001)
    fine_mm = np.append(
        0.0, np.cumsum(np.linalg.norm(np.diff(along(target, fine).node_mm[:, 0], axis=0), axis=1))
    )
    between_mm = np.diff(np.interp(looks.time_s[looks.body], fine, fine_mm))
    assert (between_mm <= looks.apart_mm + 0.1).all()
    assert set(looks.body[[0, -1]]) == {0, len(looks.time_s) - 1}


@pytest.mark.parametrize("far_mm", [10.0, 1e300])
def test_a_jump_in_no_time_is_too_fast(far_mm):
    target = Target(
        name="path",
        node_names=("tip",),
        weights=[1.0],
        time_s=[0.0, 1.0, np.nextafter(1.0, 2.0), 2.0],
        position_mm=MIDDLE_MM + np.array([0.0, 0.0, far_mm, far_mm])[:, None, None] * [1.0, 0.0, 0.0],
        repeat=False,
    )
    with np.errstate(all="ignore"), pytest.raises(TooFastError, match="tip moves at"):
        check(target, FAR_WALL)
