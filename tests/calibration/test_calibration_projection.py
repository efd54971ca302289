"""The camera's model is OpenCV's, and its derivatives are right."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.projection import by_pose, matrix, moved, project, transformed, undistorted

INTRINSICS = st.tuples(
    *(st.floats(low, high) for low, high in [(600, 2500), (600, 2500), (800, 1100), (400, 700)]),
    *(st.floats(-limit, limit) for limit in (0.2, 0.2, 0.005, 0.005, 0.1)),
).map(np.array)
POINTS = st.lists(
    st.tuples(st.floats(-60, 60), st.floats(-40, 40), st.floats(120, 400)), min_size=1, max_size=6
).map(np.array)
STEPS = st.tuples(*[st.floats(-0.5, 0.5)] * 3, *[st.floats(-20, 20)] * 3).map(np.array)


@settings(max_examples=25, deadline=None)
@given(INTRINSICS, POINTS)
def test_pixels_are_those_of_opencv(intrinsics, points_mm):
    exact, _ = cv2.projectPoints(points_mm, np.zeros(3), np.zeros(3), matrix(intrinsics), intrinsics[4:])
    np.testing.assert_allclose(project(intrinsics, points_mm)[0], exact.reshape(-1, 2), rtol=1e-12)


@settings(max_examples=25, deadline=None)
@given(INTRINSICS, POINTS)
def test_derivatives_are_differences(intrinsics, points_mm):
    _, by_point, by_intrinsics = project(intrinsics, points_mm)
    for axis, step in enumerate(1e-4 * np.eye(3)):
        ahead, behind = (project(intrinsics, points_mm + sign * step)[0] for sign in (1, -1))
        np.testing.assert_allclose(by_point[..., axis], (ahead - behind) / 2e-4, atol=1e-5, rtol=1e-5)
    for axis, step in enumerate(1e-5 * np.eye(9)):
        ahead, behind = (project(intrinsics + sign * step, points_mm)[0] for sign in (1, -1))
        np.testing.assert_allclose(by_intrinsics[..., axis], (ahead - behind) / 2e-5, atol=1e-5, rtol=1e-5)


@settings(max_examples=25, deadline=None)
@given(STEPS, POINTS)
def test_a_pose_moves_as_its_derivatives_say(start, points_mm):
    pose = moved(np.eye(4), start)
    derivatives = by_pose(pose, points_mm)
    for axis, step in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (transformed(moved(pose, sign * step), points_mm) for sign in (1, -1))
        np.testing.assert_allclose(derivatives[..., axis], (ahead - behind) / 2e-6, atol=1e-5)


def test_undistorting_takes_a_pixel_back_to_its_ray():
    intrinsics = np.array([1436.4, 1434.9, 966.8, 531.3, 0.082, -0.171, 0.0009, -0.0006, 0.031])
    points_mm = np.array([[x, y, 190.0] for x in (-110, 0, 110) for y in (-60, 0, 60)])
    ideal = undistorted(intrinsics, project(intrinsics, points_mm)[0])
    np.testing.assert_allclose(ideal, points_mm[:, :2] / 190.0, atol=1e-8)
