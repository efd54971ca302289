import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from drivers.simulated.robot.subsegment import hat, move_along, move_with_slopes

LENGTH = np.array([4.0])
strains = st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3).map(np.array)


def exponential(strain, length):
    twist = np.zeros((4, 4))
    twist[:3, :3] = hat(strain)
    twist[2, 3] = 1.0
    return expm(twist * length)


@given(strains)
def test_motion_over_a_piece_is_the_exponential_of_its_strain(strain):
    expected = exponential(strain, 4.0)
    pieces = move_with_slopes(strain[None], LENGTH)
    moved = move_along(strain[None], LENGTH)[0]
    np.testing.assert_allclose(pieces.rotation[0], expected[:3, :3], atol=1e-9)
    np.testing.assert_allclose(pieces.translation[0], expected[:3, 3], atol=1e-9)
    np.testing.assert_allclose(moved[:, 0], expected[:3, 3], atol=1e-9)
    np.testing.assert_allclose(moved[:, 1], expected[:3, 2], atol=1e-9)


@given(strains)
def test_slopes_are_derivatives(strain):
    pieces = move_with_slopes(strain[None], LENGTH)
    for axis, change in enumerate(np.eye(3) * 1e-6):
        forward, backward = (exponential(strain + sign * change / 4.0, 4.0) for sign in (1, -1))
        shift = (forward[:3, 3] - backward[:3, 3]) / 2e-6
        turn = (forward[:3, :3] - backward[:3, :3]) / 2e-6 @ pieces.rotation[0].T
        np.testing.assert_allclose(pieces.translation_slope[0, :, axis], shift, atol=1e-6)
        np.testing.assert_allclose(hat(pieces.rotation_axes[0, :, axis]), turn, atol=1e-6)
