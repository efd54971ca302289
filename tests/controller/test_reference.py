"""Targets become bounded, smooth motions that can be paused."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.easing import EASING_S, Stretch
from controller.path import along
from controller.reference import Reference
from messaging.control import Target

START_MM = np.array([[0.0, 0.0, 80.0]])
BEGIN_MM = np.array([[0.0, 0.0, 84.0]])


def line(*, repeat=False, end=(10.0, 0.0, 84.0), seconds=2.0):
    return path([0.0, seconds], [BEGIN_MM[0], end], repeat=repeat)


def path(time_s, places_mm, *, repeat=False, repeat_from_s=0.0):
    return Target(
        name="line",
        node_names=("tip",),
        weights=[1.0],
        time_s=time_s,
        position_mm=np.reshape(places_mm, (-1, 1, 3)),
        repeat=repeat,
        repeat_from_s=repeat_from_s,
    )


def speed(desired):
    return np.linalg.norm(desired.velocity_mm_s, axis=-1).max()


@settings(max_examples=40)
@given(st.tuples(*[st.floats(-30, 30)] * 3), st.floats(1.0, 50.0))
def test_the_approach_never_exceeds_its_speed_and_arrives_at_rest(away, speed_mm_s):
    start = START_MM + away
    reference = Reference.towards(line(), start, 5.0, speed_mm_s)
    times = np.linspace(5.0, 5.0 + reference.approach_s, 100, endpoint=False)
    at = [reference.at(t) for t in times]
    np.testing.assert_allclose(at[0].node_mm, start)
    assert max(map(speed, at)) <= speed_mm_s * 1.0001
    steps = np.linalg.norm(np.diff([d.node_mm[0] for d in at], axis=0), axis=1)
    assert (steps <= speed_mm_s * (times[1] - times[0]) * 1.0001 + 1e-9).all()
    np.testing.assert_allclose(reference.at(5.0 + reference.approach_s).node_mm, BEGIN_MM, atol=1e-9)


@settings(max_examples=40)
@given(st.tuples(*[st.floats(-30, 30)] * 3), st.tuples(*[st.floats(-10, 10)] * 3))
def test_what_moves_already_goes_over_into_the_approach_without_a_jump(away, moving):
    moving_mm_s = np.array([moving])
    reference = Reference.towards(line(), START_MM + away, 5.0, 20.0, start_mm_s=moving_mm_s)
    np.testing.assert_allclose(reference.at(5.0).velocity_mm_s, moving_mm_s, atol=1e-9)
    arrived_s = 5.0 + reference.approach_s
    assert max(speed(reference.at(t)) for t in np.linspace(5.0, arrived_s, 60)) <= 20.0 * 1.0001
    np.testing.assert_allclose(reference.at(arrived_s).node_mm, BEGIN_MM, atol=1e-9)


def test_two_motions_in_one_direction_keep_to_the_bound_together():
    reference = Reference.towards(
        line(), BEGIN_MM - [[5.0, 0.0, 0.0]], 0.0, 20.0, start_mm_s=np.array([[19.0, 0.0, 0.0]])
    )
    assert max(speed(reference.at(t)) for t in np.linspace(0.0, reference.approach_s, 200)) <= 20.0


@pytest.mark.parametrize("repeat_from_s", [0.0, 1.0])
def test_velocity_is_continuous_at_every_moment_of_a_path_that_repeats(repeat_from_s):
    places = [
        (0, 0, 84),
        (5, 0, 85),
        (8, 5, 87),
        (-3, -4, 83),
        (0, 0, 84) if not repeat_from_s else (5, 0, 85),
    ]
    target = path([0, 1, 1.5, 3, 4], places, repeat=True, repeat_from_s=repeat_from_s)
    for moment_s in (1, 1.5, 3, 4, 4 + (1.5 - repeat_from_s), 8 - repeat_from_s, 12 - 2 * repeat_from_s):
        before, after = along(target, np.array([moment_s - 1e-9, moment_s + 1e-9])).velocity_mm_s
        np.testing.assert_allclose(before, after, atol=1e-5)
    assert np.abs(along(target, 4.0).velocity_mm_s).max() > 1, "it does not stand at its seam"


@settings(max_examples=60)
@given(st.data())
def test_velocity_is_the_derivative_of_position_and_continuous(data):
    steps = data.draw(st.lists(st.floats(0.2, 3.0), min_size=1, max_size=5))
    times = np.concatenate([[0.0], np.cumsum(steps)])
    places = [data.draw(st.tuples(*[st.floats(-10, 10)] * 3)) for _ in times]
    repeat = data.draw(st.booleans())
    if repeat:
        places[-1] = places[0]
    reference = Reference.towards(
        path(times, places, repeat=repeat), START_MM, 0.0, 20.0, start_mm_s=np.array([[1.0, 2.0, 3.0]])
    )
    reference = reference.paused(data.draw(st.floats(0.0, 5.0)))
    reference = reference.resumed(data.draw(st.floats(5.4, 6.0)))
    t, small = data.draw(st.floats(0.0, 20.0)), 1e-5
    behind, here, ahead = (reference.at(t + shift) for shift in (-small, 0.0, small))
    # a corner of the acceleration within the difference leaves a trace of the order of the step
    np.testing.assert_allclose(here.velocity_mm_s, (ahead.node_mm - behind.node_mm) / (2 * small), atol=0.02)
    np.testing.assert_allclose(ahead.velocity_mm_s, behind.velocity_mm_s, atol=0.05)


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=6), st.data())
def test_between_moments_nothing_goes_beyond_what_they_say(heights, data):
    times = np.concatenate([[0.0], np.cumsum([data.draw(st.floats(0.1, 3.0)) for _ in heights[1:]])])
    target = path(times, [(0.0, 2.0 * z, z) for z in heights])
    for before, (low, high) in enumerate(itertools.pairwise(heights)):
        between = along(target, np.linspace(times[before], times[before + 1], 30)).node_mm[:, 0]
        assert (between[:, 2] >= min(low, high) - 1e-9).all()
        assert (between[:, 2] <= max(low, high) + 1e-9).all()
        np.testing.assert_allclose(between[:, 1], 2 * between[:, 2], atol=1e-9)


def test_a_path_ends_at_its_last_position_or_repeats(stand_ins):
    once = Reference.towards(line(), BEGIN_MM, 0.0, 10.0)
    np.testing.assert_allclose(once.at(1.0 + EASING_S / 2).node_mm, [[5.0, 0.0, 84.0]])
    np.testing.assert_allclose(once.at(50.0).node_mm, [[10.0, 0.0, 84.0]])
    np.testing.assert_array_equal(once.at(50.0).velocity_mm_s, np.zeros((1, 3)))
    circle = stand_ins["circle"](period_s=10.0)
    turning = Reference.towards(circle, circle.position_mm[0], 0.0, 10.0)
    np.testing.assert_allclose(turning.at(3.0).node_mm, turning.at(23.0).node_mm, atol=1e-9)


def test_a_path_may_go_back_to_a_later_moment_than_its_first():
    target = path(
        [0, 1, 2, 3], [(0, 0, 84), (5, 0, 84), (5, 5, 84), (5, 0, 84)], repeat=True, repeat_from_s=1.0
    )
    again = along(target, np.array([1.5, 3.5, 5.5]))
    np.testing.assert_allclose(again.node_mm[:, 0, 0], 5.0)
    np.testing.assert_allclose(again.node_mm[1], again.node_mm[2])
    reference = Reference.towards(target, np.array([[0.0, 0.0, 84.0]]), 0.0, 10.0)
    assert reference.progress(EASING_S / 2 + 2.0) == pytest.approx(0.5)
    assert reference.progress(EASING_S / 2 + 4.5) == pytest.approx(0.75)
    assert reference.progress(1e6) < 1


@given(st.floats(0.01, 5.0), st.floats(0.0, 1.0))
def test_a_stretch_is_run_through_whole_and_no_faster_than_its_own_pace(length_s, share):
    stretch = Stretch(length_s=length_s)
    assert stretch.at(stretch.duration_s) == (length_s, 0.0)
    elapsed_s, small = share * stretch.duration_s, 1e-6
    done, rate = stretch.at(elapsed_s)
    assert 0 <= done <= length_s + 1e-9
    assert 0 <= rate <= 1
    assert stretch.at(elapsed_s + small)[0] - done == pytest.approx(rate * small, abs=1e-9)


def test_a_path_is_joined_where_it_was_left(stand_ins):
    circle = stand_ins["circle"](period_s=10.0)
    reference = Reference.towards(circle, np.array([[0.0, 0.0, 80.0]]), 50.0, 10.0, joined_s=2.5)
    arrived_s = 50.0 + reference.approach_s + 1e-9
    np.testing.assert_allclose(reference.at(arrived_s).node_mm, [[0.0, 15.0, 82.0]], atol=0.05)
    assert not reference.joined(51.0)
    assert reference.path_s(51.0) == 2.5
    assert reference.joined(arrived_s)
    assert reference.path_s(arrived_s + 1.0 + EASING_S / 2) == pytest.approx(3.5)


@pytest.mark.parametrize("pause_s", [0.5, 1.5, 2.2])
def test_a_pause_stands_still_anywhere_and_goes_on_from_there(pause_s):
    reference = Reference.towards(line(), START_MM, 0.0, 10.0)
    paused = reference.paused(pause_s)
    np.testing.assert_allclose(paused.at(pause_s).node_mm, reference.at(pause_s).node_mm)
    stood = paused.at(pause_s + EASING_S)
    np.testing.assert_array_equal(stood.velocity_mm_s, np.zeros((1, 3)))
    np.testing.assert_array_equal(paused.at(pause_s + 100.0).node_mm, stood.node_mm)
    assert paused.progress(pause_s + 100.0) < 1
    assert paused.progress(pause_s + 100.0) < 1
    resumed = paused.resumed(pause_s + 100.0)
    np.testing.assert_array_equal(resumed.at(pause_s + 100.0).node_mm, stood.node_mm)
    np.testing.assert_allclose(
        resumed.at(pause_s + 100.0 + 1.0).node_mm, reference.at(pause_s + 1.0).node_mm, atol=1e-9
    )


def test_a_pause_brakes_no_harder_than_it_must_even_when_resumed_halfway():
    reference = Reference.towards(line(seconds=4.0), BEGIN_MM, 0.0, 10.0)
    reference = reference.paused(2.0).resumed(2.1).paused(2.15)
    times = np.arange(1.9, 2.6, 0.001)
    velocity = np.array([reference.at(t).velocity_mm_s[0, 0] for t in times])
    assert velocity[0] > 2
    assert velocity[-1] == 0
    assert np.abs(np.diff(velocity)).max() / 0.001 < 1.6 * 2.5 / EASING_S


def test_progress_rises_from_nothing_to_all_of_it():
    reference = Reference.towards(line(), START_MM, 3.0, 10.0)
    end_s = 3.0 + reference.approach_s + 2.0 + EASING_S
    shares = [reference.progress(t) for t in np.linspace(3.0, end_s, 50)]
    assert shares[0] == 0
    assert shares[-1] == pytest.approx(1)
    assert (np.diff(shares) > 0).all()
    assert reference.progress(end_s - 0.01) < 1
    assert reference.progress(end_s + 0.01) == 1


def test_watched_points_do_not_slow_down_the_approach():
    watched = Target(
        name="watched",
        node_names=("tip", "middle"),
        weights=[1.0, 0.0],
        time_s=[0.0],
        position_mm=[[[5.0, 0.0, 82.0], [999.0, 0.0, 0.0]]],
        repeat=False,
    )
    assert Reference.towards(watched, np.zeros((2, 3)), 0.0, 10.0).approach_s < 60.0


def test_a_path_that_begins_where_the_robot_is_has_no_approach_and_may_be_asked_about_the_past():
    """The shape that a new target is compared with was taken before the target came."""
    reference = Reference.towards(line(), BEGIN_MM, 5.0, 10.0)
    assert reference.approach_s == 0
    np.testing.assert_allclose(reference.at(4.95).node_mm, BEGIN_MM)
