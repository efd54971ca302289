"""Light that changed between the background picture and the frame."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.pictures.light import LINEAR, light_gains, luma, relit

LEVELS = np.arange(256, dtype=np.uint8)


@given(gain=st.floats(0.3, 3.0))
def test_light_is_scaled_and_not_levels(gain):
    seen = relit(LEVELS.reshape(16, 16), np.array([gain])).ravel()
    light = gain * LINEAR
    unclipped = light < 250
    # half a level of rounding, at the steep end of the curve
    assert np.abs(LINEAR[seen][unclipped] - light[unclipped]).max() < 1.2
    assert (seen[light > 256] == 255).all()


def test_light_that_did_not_change_changes_no_level():
    picture = np.random.default_rng(1).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    assert np.array_equal(relit(picture, np.ones(3)), picture)


def test_every_colour_has_its_own_gain():
    picture = np.full((4, 5, 3), 100, np.uint8)
    blue, green, red = relit(picture, np.array([0.5, 1.0, 2.0]))[0, 0]
    assert blue < green == 100 < red


@given(gain=st.floats(0.5, 2.0), share=st.floats(0.0, 0.4), seed=st.integers(0, 100))
def test_the_gain_is_found_beside_a_robot_and_noise(gain, share, seed):
    random = np.random.default_rng(seed)
    known = random.integers(70, 110, (2000, 3)).astype(np.uint8)
    seen = relit(known[None], np.full(3, gain))[0] + random.normal(0, 2, known.shape)
    seen[: int(share * len(seen))] = 20
    found = light_gains(np.clip(seen, 0, 255).round().astype(np.uint8), known)
    assert found == pytest.approx(np.full(3, gain), rel=0.03)


def test_nothing_to_compare_is_no_change():
    black, white = np.zeros((500, 3), np.uint8), np.full((500, 3), 255, np.uint8)
    assert light_gains(black, white).tolist() == [1, 1, 1]
    assert light_gains(np.full((9, 3), 80, np.uint8), np.full((9, 3), 40, np.uint8)).tolist() == [1, 1, 1]


def test_brightness_of_a_grey_picture_is_the_picture():
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4)
    assert luma(grey) is grey
    assert luma(np.full((1, 1, 3), (0, 255, 0), np.uint8))[0, 0] == 150
