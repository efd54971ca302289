"""Configurations keep to the travels of the axes, and lie in space where the model puts them."""

import numpy as np
import pytest

from controller.planning.space import Space


def test_configurations_are_brought_within_all_travels_and_no_farther(any_space, random):
    asked = random.uniform(-12, 60, (200, any_space.coordinates))
    within = any_space.within(asked)
    limits, commands = any_space.plant.limits, any_space.commands(within)
    assert (commands <= limits.high_mm + 1e-9).all()
    assert (commands >= limits.low_mm - 1e-9).all()
    np.testing.assert_allclose(any_space.within(within), within, atol=1e-9)
    # one axis at the least stands at its end where something was cut off
    at_end = np.isclose(np.abs(commands), limits.high_mm) | np.isclose(commands, limits.low_mm)
    cut = np.abs(within - asked).max(axis=1) > 1e-9
    assert cut.any()
    assert at_end[cut].any(axis=1).all()


def test_the_body_lies_where_the_kinematics_puts_it(any_space, random):
    some = np.array([any_space.random(random) for _ in range(20)] + [np.zeros(any_space.coordinates)])
    some[-1] = any_space.straight(10.0)
    expected = any_space.kinematics.nodes_mm(any_space.commands(some), any_space.plant.body_arc_mm)
    np.testing.assert_allclose(any_space.body_mm(some), expected, atol=1e-9)


def test_derivatives_by_coordinates_are_those_of_positions(any_space, random):
    here, arc = any_space.random(random), any_space.plant.body_arc_mm
    _, jacobian = any_space.nodes_and_jacobian(here, arc)
    step = 1e-6 * np.eye(any_space.coordinates)
    ahead, behind = (any_space.nodes_and_jacobian(here + s, arc)[0] for s in (step, -step))
    np.testing.assert_allclose(jacobian, np.moveaxis(ahead - behind, 0, -1) / 2e-6, atol=1e-6)


def test_the_body_sweeps_no_farther_than_is_said(any_space, random):
    some, others = (np.array([any_space.random(random) for _ in range(50)]) for _ in range(2))
    moved = np.linalg.norm(any_space.body_mm(others) - any_space.body_mm(some), axis=-1).max(axis=-1)
    assert (moved <= any_space.sweep_mm(others - some) + 1e-9).all()


def test_the_nearest_region_is_named_with_where_and_how_near(stand_ins):
    space = Space(stand_ins["plant"](stand_ins["settings"](forbidden=(stand_ins["WALL"], stand_ins["LAMP"]))))
    nearest = space.nearest(np.stack([space.straight(39.5), space.straight(0.0)]))
    # the straight body passes the lamp's centre 22 mm away, at one of the points that are looked at every 5 mm
    assert (nearest.region, nearest.arc_mm, nearest.index) == ("lamp", 60.0, 1)
    assert nearest.spare_mm == pytest.approx(np.hypot(22, 2) - 6 - 5)
    np.testing.assert_allclose(nearest.point_mm, [0, 0, 60])
    np.testing.assert_allclose(space.spare_mm(space.straight(0.0)), nearest.spare_mm)


def test_what_stands_between_two_configurations_is_found(stand_ins):
    space = Space(stand_ins["plant"](stand_ins["settings"](forbidden=(stand_ins["LAMP"],))))
    low, high = np.array([[3.6, 0, 3.6, 0, 0], [1.5, 0, 1.5, 0, 40.0]])
    way = np.stack([low, low, high])
    assert space.nearest(way).spare_mm > 0
    nearest = space.nearest_between(way)
    assert nearest.spare_mm < 0
    assert nearest.index in (1, 2), "counted by the configurations on both sides of it"
    assert nearest.spare_mm == pytest.approx(space.nearest_between(way[::-1]).spare_mm)


def test_without_regions_all_is_clear(any_space):
    assert any_space.nearest(any_space.straight(0.0)[None]) is None
    assert any_space.nearest_between(any_space.straight(0.0)[None]) is None
    assert any_space.spare_mm(any_space.straight(0.0)) == np.inf
