"""Lost motion forth and back: what the inverse asks of an axis is what the robot feels."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from controller.lost_motion import engaged_after, felt_mm, motion_for, stretch

engaged = st.floats(-1, 1)
widths = st.floats(0, 2)
engaging = st.floats(0.01, 1)
steps = st.floats(-1, 1)


def one(value):
    return np.array([value])


@given(engaged, widths, engaging, steps)
def test_the_inverse_brings_about_what_was_asked_to_be_felt(before, width, engaging_mm, wanted):
    position, start, width = one(3.0), one(before), one(width)
    moved = motion_for(one(wanted), start, width, engaging_mm)
    after = engaged_after(start, moved, width, engaging_mm)
    felt = felt_mm(position + moved, after, width) - felt_mm(position, start, width)
    np.testing.assert_allclose(felt, wanted, atol=1e-9)


@given(engaged, widths, engaging, steps)
def test_no_more_is_moved_than_the_stretch_says(before, width, engaging_mm, wanted):
    back, on = stretch(one(before), one(width), engaging_mm)
    moved = motion_for(one(wanted), one(before), one(width), engaging_mm)
    most = abs(wanted) * (on if wanted > 0 else back)
    assert abs(wanted) - 1e-12 <= abs(moved) <= most + 1e-12


@given(engaged, widths, engaging, st.lists(steps, max_size=20))
def test_a_place_in_the_lost_motion_stays_in_it(before, width, engaging_mm, moves):
    place = one(before)
    for move in moves:
        place = engaged_after(place, one(move), one(width), engaging_mm)
        assert -1 <= place <= 1


def test_turning_round_loses_the_whole_width():
    width, engaging_mm = one(0.4), 1e-6
    place = engaged_after(one(1.0), one(-0.4), width, engaging_mm)
    felt = felt_mm(one(-0.4), place, width) - felt_mm(one(0.0), one(1.0), width)
    np.testing.assert_allclose(felt, 0.0, atol=1e-5)
