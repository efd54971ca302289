"""The quadratic programme: whatever is asked, what it answers keeps every limit, and standing still is always allowed."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from controller.allocation import Allocation, Body, Wish, tightening_mm_s
from controller.plant import Plant
from controller.regions import HalfSpace, Sphere
from controller.settings import ControllerSettings, SectionTendons
from messaging.settings import RobotSettings

ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))
TIP = np.array([80.0])
PLAIN = Plant.of(ControllerSettings(), ROBOT)
NOBODY = Body(point_mm=np.zeros((0, 3)), jacobian=np.zeros((0, 3, 5)))
ONES = (np.ones(5), np.ones(5))
FREE = np.ones(5, dtype=bool)


def plant(**changes):
    return Plant.of(msgspec.structs.replace(ControllerSettings(), **changes), ROBOT)


def answer(wanted_mm_s, command_mm, *, of=PLAIN, current_ma=None, movable=FREE, stretch=ONES, body=NOBODY):
    """Rates for a tip that should move so."""
    _, jacobian = of.kinematics.nodes_and_jacobian(command_mm, TIP)
    wish = Wish(rows=jacobian[0], rate_mm_s=np.asarray(wanted_mm_s, dtype=float))
    return Allocation(of, damping_mm=0.5, insertion_cost=0.1).rates(
        wish,
        np.zeros(5),
        movable,
        command_mm=command_mm,
        current_ma=current_ma,
        stretch=stretch,
        body=body,
    )


def commands():
    return st.tuples(arrays(np.float64, 4, elements=st.floats(-5, 5)), st.floats(0, 40)).map(
        lambda parts: np.append(*parts)
    )


wanted = arrays(np.float64, 3, elements=st.floats(-500, 500))
currents = arrays(np.float64, 5, elements=st.floats(-1500, 1500))


@settings(max_examples=150, deadline=None)
@given(wanted, commands(), currents, st.floats(1, 5))
def test_rates_travels_and_currents_are_kept(speed, command, current, stretched):
    limits = PLAIN.limits
    rate = answer(speed, command, current_ma=current, stretch=(np.full(5, stretched), np.full(5, stretched)))
    assert (np.abs(rate) * stretched <= limits.rate_mm_s + 1e-12).all()
    after = command + rate * stretched * 0.1
    assert (after >= limits.low_mm - 1e-9).all()
    assert (after <= limits.high_mm + 1e-9).all()
    pulled_hard = np.abs(current) >= 0.9 * limits.current_ma
    assert (rate[pulled_hard] * np.sign(current[pulled_hard]) <= 0).all()


@settings(max_examples=60, deadline=None)
@given(wanted, commands())
def test_axes_that_may_not_move_do_not(speed, command):
    movable = np.array([True, False, True, True, False])
    assert (answer(speed, command, movable=movable)[~movable] == 0).all()


@settings(max_examples=60, deadline=None)
@given(wanted, commands())
def test_the_answer_is_at_least_as_good_as_cutting_least_squares_short(speed, command):
    limits = PLAIN.limits
    _, jacobian = PLAIN.kinematics.nodes_and_jacobian(command, TIP)
    weight = np.diag((0.5 * np.array([1, 1, 1, 1, 0.1])) ** 2)
    free = np.linalg.solve(jacobian[0].T @ jacobian[0] + weight, jacobian[0].T @ speed)
    low = np.maximum(-limits.rate_mm_s, (limits.low_mm - command) / 0.1)
    high = np.minimum(limits.rate_mm_s, (limits.high_mm - command) / 0.1)

    def cost(rate):
        return float(((jacobian[0] @ rate - speed) ** 2).sum() + rate @ weight @ rate)

    best = cost(answer(speed, command))
    assert best <= cost(np.clip(free, low, high)) * (1 + 1e-6) + 1e-6


def test_what_is_asked_is_done_where_nothing_is_in_the_way():
    rate = answer([3.0, -2.0, 1.0], np.array([0.5, -0.3, 0.2, 0.4, 10.0]))
    _, jacobian = PLAIN.kinematics.nodes_and_jacobian(np.array([0.5, -0.3, 0.2, 0.4, 10.0]), TIP)
    np.testing.assert_allclose(jacobian[0] @ rate, [3.0, -2.0, 1.0], atol=0.05)


@pytest.mark.parametrize(
    "region",
    [
        Sphere(name="lamp", centre_mm=(30.0, 0.0, 80.0), radius_mm=20.0),
        HalfSpace(name="wall", point_mm=(10.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0)),
    ],
)
def test_the_body_nears_a_region_no_faster_than_its_distance_allows(region):
    inside = plant(forbidden=(region,), keep_clear_mm=4.0)
    command = np.array([0.4, 0.0, 0.1, 0.0, 0.0])
    point, jacobian = inside.kinematics.nodes_and_jacobian(command, inside.body_arc_mm)
    rate = answer([40.0, 0.0, 0.0], command, of=inside, body=Body(point_mm=point, jacobian=jacobian))
    distance, _ = inside.regions.clearance(point)
    later, _ = inside.regions.clearance(point + jacobian @ rate * 1e-6)
    nearing = (later - distance) / 1e-6
    assert (nearing >= -(distance - 4.0) / 0.1 - 1e-3).all()
    unhindered = answer([40.0, 0.0, 0.0], command)
    assert np.linalg.norm(rate - unhindered) > 0.1


def test_a_body_inside_a_region_is_led_out_of_it():
    inside = plant(
        forbidden=(HalfSpace(name="wall", point_mm=(-3, 0, 0), normal=(-1, 0, 0)),), keep_clear_mm=0.0
    )
    command = np.array([0.4, 0.0, 0.1, 0.0, 0.0])
    point, jacobian = inside.kinematics.nodes_and_jacobian(command, TIP)
    rate = answer([40.0, 0.0, 0.0], command, of=inside, body=Body(point_mm=point, jacobian=jacobian))
    assert (jacobian @ rate)[0, 0] < 0


def test_single_tendons_are_kept_from_going_slack_and_pairs_left_alone():
    three = SectionTendons(tendon_angle_deg=(90.0, -30.0, 210.0))
    single = plant(sections=(three, three))
    least = single.limits.least_tension_ma
    slack = np.array([0.0, 5 * least / 2, 5 * least / 2, least, least, least, 0.0])
    rate = tightening_mm_s(single, slack)
    assert (rate[:3] > 0).all()
    np.testing.assert_allclose(rate[3:], 0.0, atol=1e-12)
    np.testing.assert_allclose(single.kinematics.coordinates_of_command @ rate, 0.0, atol=1e-12)
    assert (tightening_mm_s(single, 10 * least * np.ones(7))[:6] < 0).all()
    assert not tightening_mm_s(PLAIN, np.zeros(5)).any()
