"""Detection pixels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.pictures.grid import Grid


@pytest.mark.parametrize(
    ("size_px", "step"),
    [
        ((320, 240), 1),
        ((640, 480), 1),
        ((1280, 720), 1),
        ((1920, 1080), 2),
        ((2592, 1944), 2),
        ((3840, 2160), 4),
    ],
)
def test_detection_takes_pictures_about_960_px_wide(size_px, step):
    grid = Grid.of(size_px)
    assert grid.step == step
    assert grid.shape == (-(-size_px[1] // step), -(-size_px[0] // step))


def test_detection_pixels_are_means():
    picture = np.zeros((2, 4, 3), np.uint8)
    picture[:, 2:] = [[[10, 0, 0], [20, 0, 0]], [[30, 0, 0], [40, 0, 0]]]
    assert Grid((4, 2), 2).reduced(picture).tolist() == [[[0, 0, 0], [25, 0, 0]]]


def test_what_is_left_over_at_the_rim_belongs_to_a_pixel_too():
    picture = 4 * np.arange(15, dtype=np.uint8).reshape(3, 5)
    assert Grid((5, 3), 2).reduced(picture).tolist() == [[12, 20, 26], [42, 50, 56]]
    assert Grid((5, 3), 2).shape == (2, 3)


@given(step=st.sampled_from([1, 2, 4]), x=st.floats(-50, 4000), y=st.floats(-50, 4000))
def test_places_come_back(step, x, y):
    grid = Grid((3840, 2160), step)
    assert grid.fine(grid.coarse(np.array([x, y]))) == pytest.approx([x, y])


@pytest.mark.parametrize("step", [2, 4])
def test_a_spot_is_where_its_coordinates_say(step):
    picture = np.zeros((64, 96), np.uint8)
    picture[8 * step : 9 * step, 3 * step : 4 * step] = 255
    grid = Grid((96, 64), step)
    y, x = np.unravel_index(grid.reduced(picture).argmax(), grid.shape)
    middle = np.array([3.5 * step - 0.5, 8.5 * step - 0.5])
    assert grid.coarse(middle) == pytest.approx([x, y])
