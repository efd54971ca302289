"""How far two robot frames lie apart, and when that is too far."""

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration.base import Base, Matrix4, Matrix6, apart_from, difference

angles = st.floats(-3.0, 3.0)
places = st.floats(-300.0, 300.0)


def frame(turn, place):
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(np.array(turn, float))[0]
    matrix[:3, 3] = place
    return matrix


def base(matrix, sigma=(0.001,) * 3 + (0.1,) * 3):
    return Base(
        way="robot",
        rig_from_robot=msgspec.convert(matrix.tolist(), Matrix4),
        covariance=msgspec.convert(np.diag(np.square(sigma)).tolist(), Matrix6),
        residual_px={},
        residual_mm=0.0,
        frame_sets=1,
    )


@given(
    st.tuples(angles, angles, angles),
    st.tuples(places, places, places),
    st.floats(0.0, 1.0),
    angles,
    st.floats(-1.0, 1.0),
    st.tuples(places, places, places),
)
def test_tilt_and_roll_and_shift_are_told_apart(turn, place, tilt, towards, roll, shift):
    one = frame(turn, place)
    tilted = frame([-tilt * np.sin(towards), tilt * np.cos(towards), 0], shift)
    apart = apart_from(one, one @ tilted @ frame([0, 0, roll], [0, 0, 0]))
    assert apart.origin_mm == pytest.approx(np.linalg.norm(shift), abs=1e-6)
    assert apart.axis_rad == pytest.approx(tilt, abs=1e-6)
    assert apart.roll_rad == pytest.approx(roll, abs=1e-6)


@pytest.mark.parametrize(
    ("motion", "named"),
    [
        (frame([0, 0, 0], [0.3, 0, 0]), ()),
        (frame([0, 0, 0], [0.8, 0, 0]), ("origin",)),
        (frame([0.007, 0, 0], [0, 0, 0]), ("axis",)),
        (frame([0, 0, -0.005], [0, 0, 0]), ("roll",)),
        (frame([0, 0, 0.05], [5, 0, 0]), ("origin", "roll")),
    ],
)
def test_what_is_further_apart_than_three_sigma_is_named(motion, named):
    one = frame([0.3, 1.2, -0.4], [10, -20, 200])
    # sigmas of both: origin 0.24 mm, axis 2 mrad, roll 1.4 mrad
    assert difference(base(one), base(one @ motion)).too_large == named
