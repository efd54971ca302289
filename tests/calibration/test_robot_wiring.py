"""Signs, exchanged pairs and a turned frame, told from how nodal points move."""

import numpy as np

from calibration.robot_wiring import turned_rad, wired

SHARE = np.array([[5, 20, 35, 40], [5, 20, 35, 40], [0, 0, 5, 20], [0, 0, 5, 20]]) / 10
HEADING = np.radians([0, 90, 45, 135])
DRAWN = SHARE[..., None] * np.stack([np.cos(HEADING), np.sin(HEADING), 0 * HEADING], axis=-1)[:, None]


def seen(*order, signs=(1, 1, 1, 1), seed=1):
    noise = np.random.default_rng(seed).normal(0, 0.02, DRAWN.shape)
    return np.array(signs)[:, None, None] * DRAWN[list(order)] * 0.6 + noise


def test_what_is_right_is_right():
    assert all(
        axis.pulls == axis.axis and not axis.backwards and axis.alike
        for axis in wired(seen(0, 1, 2, 3), DRAWN)
    )


def test_one_that_goes_the_other_way_is_named():
    found = wired(seen(0, 1, 2, 3, signs=(1, 1, 1, -1)), DRAWN)
    assert [axis.axis for axis in found if axis.reversed] == [3]


def test_exchanged_pairs_are_named_and_are_no_matter_of_signs():
    found = wired(seen(0, 3, 2, 1, signs=(1, -1, 1, 1)), DRAWN)
    assert [(axis.axis, axis.pulls, axis.backwards) for axis in found if axis.misplaced] == [
        (1, 3, True),
        (3, 1, False),
    ]
    assert not any(axis.reversed for axis in found)


def test_sideways_is_like_nothing():
    motion = seen(0, 1, 2, 3)
    motion[0] = motion[0] @ np.array([[0.7, 0.7, 0], [-0.7, 0.7, 0], [0, 0, 1]])
    strange, *others = wired(motion, DRAWN)
    assert not strange.alike
    assert all(axis.alike for axis in others)


def test_a_turned_frame_is_told_from_single_axes():
    angle = np.radians(30)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    found_rad, left = turned_rad(seen(0, 1, 2, 3) @ turn.T, DRAWN)
    assert abs(found_rad - angle) < 0.02
    assert left > 0.99
    _, spoilt = turned_rad(seen(0, 1, 2, 3, signs=(1, 1, 1, -1)), DRAWN)
    assert spoilt < 0
