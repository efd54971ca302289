"""Places that a robot can reach are reached, whatever the robot; and what needs rates is asked for fairly."""

import numpy as np
import pytest

from controller.planning.rates import rate_shares
from controller.planning.solving import Wanted, missed_mm, solve_path
from controller.planning.space import Space


def wanted_by(space, configurations, arc_mm):
    arc_mm = np.array(arc_mm)
    places, _ = space.nodes_and_jacobian(configurations, arc_mm)
    return Wanted(place_mm=places, arc_mm=arc_mm, weights=np.ones(len(arc_mm)))


def test_what_is_reachable_is_reached(any_space, random):
    """Single places: nearly all of them, from the few starts that are tried."""
    places = [wanted_by(any_space, any_space.random(random)[None], [80.0]) for _ in range(30)]
    solved = [solve_path(any_space, place, near_enough_mm=0.5) for place in places]
    missed = np.array([missed_mm(any_space, p, s).max() for p, s in zip(places, solved, strict=True)])
    assert (missed < 1.0).mean() > 0.95
    assert all((np.abs(any_space.within(s) - s) < 1e-9).all() for s in solved)


def test_a_path_through_the_straight_pose_is_followed(any_space):
    bends = np.linspace(-1, 1, 40)[:, None] * any_space.weigh(1.0, 0.0) + any_space.straight(10.0)
    wanted = wanted_by(any_space, bends, [40.0, 80.0])
    solved = solve_path(any_space, wanted, near_enough_mm=0.1)
    assert missed_mm(any_space, wanted, solved).max() < 0.1


def test_a_straight_robot_that_cannot_go_down_bends_to_shorten_itself(stand_ins):
    space = Space(stand_ins["plant"](stand_ins["settings"]()))
    wanted = Wanted(place_mm=np.array([[[0.0, 0.0, 75.0]]]), arc_mm=np.array([80.0]), weights=np.ones(1))
    assert missed_mm(space, wanted, solve_path(space, wanted, near_enough_mm=0.5)).max() < 0.5


def test_the_body_is_led_clear_of_a_region_while_the_tip_stays(stand_ins):
    lamp, plain = stand_ins["LAMP"], Space(stand_ins["plant"](stand_ins["settings"]()))
    wanted = Wanted(place_mm=np.array([[[30.0, 0.0, 75.0]]]), arc_mm=np.array([80.0]), weights=np.ones(1))
    space = Space(stand_ins["plant"](stand_ins["settings"](forbidden=(lamp,))))
    assert space.spare_mm(solve_path(plain, wanted, near_enough_mm=0.5)).min() < 0, "the lamp is in the way"
    solved = solve_path(space, wanted, near_enough_mm=0.5)
    assert space.spare_mm(solved).min() >= 0
    assert missed_mm(space, wanted, solved).max() < 1.0


def test_rates_bring_about_the_motion_that_is_asked_for(any_space, random):
    some = np.array([any_space.random(random) / 2 + any_space.straight(10.0) for _ in range(20)])
    commands = any_space.commands(some)
    arc = np.array([80.0])
    _, jacobian = any_space.kinematics.nodes_and_jacobian(commands, arc)
    rates = any_space.plant.limits.rate_mm_s * random.uniform(-1, 1, commands.shape)
    velocity = np.einsum("kmda,ka->kmd", jacobian, rates)
    share = rate_shares(any_space, some, arc, np.ones((1, 1)), velocity)
    found = np.einsum("kmda,ka->kmd", jacobian, share * any_space.plant.limits.rate_mm_s)
    np.testing.assert_allclose(found, velocity, atol=0.3)
    # what some motion within all rates brings about needs little more than that
    assert np.abs(share).max() < 1.2


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_twice_the_speed_needs_twice_the_rate(stand_ins, factor):
    space = Space(stand_ins["plant"](stand_ins["settings"]()))
    here, velocity = space.straight(10.0)[None], np.array([[[4.0, 3.0, 2.0]]])
    one, other = (
        rate_shares(space, here, np.array([80.0]), np.ones((1, 1)), v) for v in (velocity, factor * velocity)
    )
    np.testing.assert_allclose(other, factor * one, rtol=1e-3, atol=1e-9)
