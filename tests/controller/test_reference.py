"""Targets become bounded motions, and what cannot be reached is refused before anything moves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.easing import EASING_S
from controller.errors import TooFastError, UnknownNodeError, UnreachableError
from controller.plant import Plant
from controller.reachability import check_target
from controller.reference import Reference
from controller.settings import ControllerSettings
from messaging.control import Target
from messaging.errors import InvalidMessageError

ARCS = {"middle": 40.0, "tip": 80.0}
START_MM = np.array([[0.0, 0.0, 80.0]])


def line(*, repeat=False, end=(10.0, 0.0, 84.0), seconds=2.0):
    return Target(
        name="line",
        node_names=("tip",),
        weights=[1.0],
        time_s=[0.0, seconds],
        position_mm=[[[0.0, 0.0, 84.0]], [end]],
        repeat=repeat,
    )


@pytest.fixture
def check(stand_ins):
    settings = ControllerSettings()
    plant = Plant.of(settings, stand_ins["ROBOT"])
    return lambda target: check_target(target, ARCS, plant, settings)


@given(st.tuples(*[st.floats(-30, 30)] * 3), st.floats(1.0, 50.0))
def test_the_approach_never_exceeds_its_speed_and_arrives_at_rest(away, speed_mm_s):
    start = START_MM + away
    reference = Reference.towards(line(), start, 5.0, speed_mm_s)
    times = np.linspace(5.0, 5.0 + reference.approach_s, 200, endpoint=False)
    at = [reference.at(t) for t in times]
    np.testing.assert_allclose(at[0].node_mm, start)
    assert max(np.linalg.norm(d.velocity_mm_s) for d in at) <= speed_mm_s * 1.0001
    steps = np.linalg.norm(np.diff([d.node_mm[0] for d in at], axis=0), axis=1)
    assert (steps <= speed_mm_s * (times[1] - times[0]) * 1.0001 + 1e-9).all()
    np.testing.assert_allclose(
        reference.at(5.0 + reference.approach_s).node_mm, [[0.0, 0.0, 84.0]], atol=1e-9
    )


@given(st.floats(0.0, 20.0))
def test_velocity_is_the_derivative_of_position(t):
    reference = Reference.towards(line(seconds=7.0), START_MM, 0.0, 3.0)
    corners = (reference.approach_s, reference.approach_s + 7.0)
    small = 1e-5
    if any(abs(t - corner) < 2 * small for corner in corners):
        return
    ahead, behind = reference.at(t + small), reference.at(t - small)
    np.testing.assert_allclose(
        reference.at(t).velocity_mm_s, (ahead.node_mm - behind.node_mm) / (2 * small), atol=1e-4
    )


def test_a_path_ends_at_its_last_position_or_repeats(stand_ins):
    once = Reference.towards(line(), np.array([[0.0, 0.0, 84.0]]), 0.0, 10.0)
    np.testing.assert_allclose(once.at(1.0 + EASING_S / 2).node_mm, [[5.0, 0.0, 84.0]])
    np.testing.assert_allclose(once.at(50.0).node_mm, [[10.0, 0.0, 84.0]])
    np.testing.assert_array_equal(once.at(50.0).velocity_mm_s, np.zeros((1, 3)))
    circle = stand_ins["circle"](period_s=10.0)
    turning = Reference.towards(circle, circle.position_mm[0], 0.0, 10.0)
    np.testing.assert_allclose(turning.at(3.0).node_mm, turning.at(23.0).node_mm, atol=1e-9)


def test_a_path_is_joined_where_it_was_left(stand_ins):
    circle = stand_ins["circle"](period_s=10.0)
    reference = Reference.towards(circle, np.array([[0.0, 0.0, 80.0]]), 50.0, 10.0, joined_s=2.5)
    arrived_s = 50.0 + reference.approach_s
    np.testing.assert_allclose(reference.at(arrived_s).node_mm, [[0.0, 15.0, 82.0]], atol=0.05)
    assert reference.path_s(51.0) == 2.5
    assert reference.path_s(arrived_s + 1.0 + EASING_S / 2) == pytest.approx(3.5)


def test_reachable_targets_pass(check, stand_ins):
    check(stand_ins["circle"]())
    check(stand_ins["circle"](radius_mm=25.0, z_mm=100.0, period_s=20.0))
    check(stand_ins["circle"](node="middle", radius_mm=5.0, z_mm=45.0))
    check(stand_ins["pose"]((0.0, 0.0, 80.0)))


@pytest.mark.parametrize(
    ("position", "message"),
    [
        (
            (0.0, 0.0, 130.0),
            r"tip at 0 s should be at \(0.0, 0.0, 130.0\) mm, 90.0 mm from .* stage travels 0 to 40",
        ),
        ((90.0, 0.0, 20.0), r"90.0 mm from the nearest place of the base; it lies 80.0 mm along the robot"),
        ((1.0, 0.0, 60.0), r"nearest that the model reaches is .* mm away \(allowed 1 mm\)"),
        ((0.0, 0.0, -70.0), r"tip at 0 s"),
    ],
)
def test_unreachable_points_are_named_with_distance_and_reach(check, stand_ins, position, message):
    with pytest.raises(UnreachableError, match=message):
        check(stand_ins["pose"](position))


def test_other_refusals(check, stand_ins):
    with pytest.raises(UnknownNodeError, match="no nodal point elbow; sensing reports middle, tip"):
        check(stand_ins["pose"]((0.0, 0.0, 80.0), node="elbow"))
    with pytest.raises(TooFastError, match=r"tip moves at 94.* mm/s .* at most 20 mm/s"):
        check(stand_ins["circle"](period_s=1.0))
    with pytest.raises(TooFastError, match=r"jumps by 10.0 mm where the path repeats"):
        check(line(repeat=True))
    with pytest.raises(InvalidMessageError, match="not finite"):
        stand_ins["pose"]((0.0, np.nan, 80.0))


def test_watched_points_may_be_anywhere(check):
    watched = Target(
        name="watched",
        node_names=("tip", "middle"),
        weights=[1.0, 0.0],
        time_s=[0.0],
        position_mm=[[[5.0, 0.0, 82.0], [999.0, 0.0, 0.0]]],
        repeat=False,
    )
    check(watched)
    assert Reference.towards(watched, np.zeros((2, 3)), 0.0, 10.0).approach_s < 60.0


def test_a_path_that_begins_where_the_robot_is_has_no_approach_and_may_be_asked_about_the_past():
    """The shape that a new target is compared with was taken before the target came."""
    reference = Reference.towards(line(), np.array([[0.0, 0.0, 84.0]]), 5.0, 10.0)
    assert reference.approach_s == 0
    np.testing.assert_allclose(reference.at(4.95).node_mm, [[0.0, 0.0, 84.0]])
