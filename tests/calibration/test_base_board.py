"""The robot frame from the board's corners in all cameras at once."""

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.base import apart_from
from calibration.base_board import base_from_board
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.corners import Corners
from calibration.errors import ViewsError

POINTS_MM = np.array([[10.0 * x, 10.0 * y, 0.0] for y in range(1, 7) for x in range(1, 9)])
ROBOT_FROM_BOARD = np.array([[1, 0, 0, -45], [0, 0, 1, 3], [0, -1, 0, 77], [0, 0, 0, 1.0]])


def pose(turn, place):
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(np.array(turn, float))[0]
    matrix[:3, 3] = place
    return matrix


def known(name, camera_from_rig, sigma=None):
    camera = {
        "name": name,
        "width_px": 1920,
        "height_px": 1080,
        "intrinsics": [[1440.0, 0.0, 960.0], [0.0, 1438.0, 540.0], [0.0, 0.0, 1.0]],
        "distortion": [0.08, -0.16, 0.0006, -0.0008, 0.027],
        "camera_from_rig": camera_from_rig.tolist(),
        "sigma": sigma or {},
    }
    return msgspec.convert(camera, CalibratedCamera)


def camera_set(sigma=None):
    # 60 degrees apart about a point 200 mm before both
    second = pose([0, np.pi / 3, 0], [0, 0, 0])
    second[:3, 3] = np.array([0, 0, 200]) - second[:3, :3] @ np.array([0, 0, 200])
    return CameraSet(cameras=(known("left", np.eye(4), sigma), known("right", second, sigma)))


RIG_FROM_ROBOT = pose([1.6, 0.2, 0.1], [2.0, 30.0, 198.0])


def seen(cameras, rig_from_robot, noise_px=0.0, seed=0):
    random = np.random.default_rng(seed)
    corners = {}
    for camera in cameras.cameras:
        place = np.array(camera.camera_from_rig) @ rig_from_robot @ ROBOT_FROM_BOARD
        px, _ = cv2.projectPoints(
            POINTS_MM,
            cv2.Rodrigues(place[:3, :3])[0],
            place[:3, 3],
            np.array(camera.intrinsics),
            np.array(camera.distortion),
        )
        px = px.reshape(-1, 2) + random.normal(0, noise_px, (len(POINTS_MM), 2))
        corners[camera.name] = Corners(np.arange(len(POINTS_MM)), px, np.ones(len(POINTS_MM)))
    return corners


@settings(max_examples=25, deadline=None)
@given(
    st.tuples(st.floats(1.3, 1.9), st.floats(0.02, 0.3), st.floats(-0.3, -0.02)),
    st.tuples(st.floats(-15, 15), st.floats(20, 40), st.floats(180, 220)),
)
def test_exact_corners_give_the_exact_frame(turn, place):
    cameras, true = camera_set(), pose(turn, place)
    base = base_from_board(cameras, [seen(cameras, true)], POINTS_MM, ROBOT_FROM_BOARD)
    apart = apart_from(true, base.matrix)
    assert apart.origin_mm < 1e-4
    assert max(apart.axis_rad, abs(apart.roll_rad)) < 1e-6


def test_noise_moves_the_frame_as_far_as_its_covariance_says():
    cameras, motions, bases = camera_set(), [], []
    for seed in range(60):
        base = base_from_board(
            cameras, [seen(cameras, RIG_FROM_ROBOT, 0.1, seed)], POINTS_MM, ROBOT_FROM_BOARD
        )
        motion = np.linalg.inv(RIG_FROM_ROBOT) @ base.matrix
        motions.append([*cv2.Rodrigues(motion[:3, :3])[0].ravel(), *motion[:3, 3]])
        bases.append(base)
    ratio = np.std(motions, axis=0) / np.sqrt(np.diag(np.mean([base.covariance for base in bases], axis=0)))
    assert (ratio > 0.7).all()
    assert (ratio < 1.35).all()
    assert bases[0].residual_px["left"] == pytest.approx(0.1, rel=0.3)
    assert bases[0].residual_mm == pytest.approx(0.1 * 200 / 1440, rel=0.3)


def test_many_pictures_are_averaged():
    cameras = camera_set()
    sets = [seen(cameras, RIG_FROM_ROBOT, 0.5, seed) for seed in range(25)]
    one, many = (
        base_from_board(cameras, some, POINTS_MM, ROBOT_FROM_BOARD).residual_px["left"]
        for some in (sets[:1], sets)
    )
    assert one == pytest.approx(0.5, rel=0.3)
    assert many == pytest.approx(0.1, rel=0.3)


def test_cameras_that_are_known_less_well_make_the_frame_less_certain():
    cameras = camera_set()
    corners = [seen(cameras, RIG_FROM_ROBOT, 0.05)]
    exact = base_from_board(cameras, corners, POINTS_MM, ROBOT_FROM_BOARD)
    doubted = base_from_board(
        camera_set({"fx_px": 1.0, "cx_px": 1.0, "k1": 0.001, "rotation_y_rad": 1e-3, "x_mm": 0.2}),
        corners,
        POINTS_MM,
        ROBOT_FROM_BOARD,
    )
    assert np.array_equal(doubted.matrix, exact.matrix)
    assert doubted.origin_sigma_mm > 5 * exact.origin_sigma_mm
    assert doubted.axis_sigma_rad > 2 * exact.axis_sigma_rad


def test_a_camera_that_hardly_sees_the_board_is_named():
    cameras = camera_set()
    corners = seen(cameras, RIG_FROM_ROBOT)
    few = Corners(np.arange(5), corners["right"].px[:5], np.ones(5))
    with pytest.raises(ViewsError, match="camera right sees 5 corners"):
        base_from_board(cameras, [corners | {"right": few}], POINTS_MM, ROBOT_FROM_BOARD)
