"""Cameras as geometry: against the pinhole formulas written out, numeric derivatives and single bright pixels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.cameras.rig import default_cameras
from messaging.frames import CameraCalibration
from sensing.geometry.camera import Camera
from sensing.pictures.light import LINEAR
from sensing.refined.edges import Walk, contrast

RIG = default_cameras()
coordinate = st.floats(-60, 60)
places = st.tuples(coordinate, coordinate, st.floats(-20, 110)).map(np.array)
calibrations = st.sampled_from(RIG)


def by_hand(calibration, point_mm):
    """A pixel by the pinhole model with k1, k2, p1, p2, k3 as OpenCV's documentation writes it."""
    x, y, z = calibration.camera_from_robot[:3, :3] @ point_mm + calibration.camera_from_robot[:3, 3]
    x, y = x / z, y / z
    k1, k2, p1, p2, k3 = calibration.distortion
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    bent = [
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        1.0,
    ]
    return (calibration.intrinsics @ bent)[:2]


@given(calibrations, places)
def test_points_appear_where_the_pinhole_formulas_put_them(calibration, point_mm):
    assert Camera(calibration).project(point_mm[None])[0] == pytest.approx(
        by_hand(calibration, point_mm), abs=1e-8
    )


@given(calibrations, places)
def test_the_ray_through_a_points_pixel_meets_the_point(calibration, point_mm):
    camera = Camera(calibration)
    ray = camera.rays(camera.project(point_mm[None]))[0]
    away = point_mm - camera.centre_mm
    assert np.linalg.norm(ray) == pytest.approx(1.0)
    assert ray @ away > 0
    assert np.linalg.norm(away - (away @ ray) * ray) < 1e-6


@given(calibrations, st.floats(0, 1919), st.floats(0, 1079), st.floats(50, 400))
def test_a_point_along_a_pixels_ray_appears_in_that_pixel(calibration, x, y, depth_mm):
    camera = Camera(calibration)
    point_mm = camera.centre_mm + depth_mm * camera.rays(np.array([[x, y]]))
    assert camera.project(point_mm)[0] == pytest.approx([x, y], abs=1e-5)


@given(calibrations, places)
def test_the_jacobian_is_the_derivative(calibration, point_mm):
    camera = Camera(calibration)
    pixels, jacobian = camera.project_with_jacobian(point_mm[None])
    assert pixels == pytest.approx(camera.project(point_mm[None]))
    step = 1e-3 * np.eye(3)
    numeric = (camera.project(point_mm + step) - camera.project(point_mm - step)).T / 2e-3
    assert jacobian[0] == pytest.approx(numeric, abs=1e-5)


def test_the_centre_is_where_the_camera_stands():
    pose = np.eye(4)
    pose[:3, :3] = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    pose[:3, 3] = [5, -2, 11]
    camera = Camera(
        CameraCalibration(
            camera="one",
            width_px=64,
            height_px=48,
            intrinsics=np.array([[100.0, 0, 30], [0, 110, 20], [0, 0, 1]]),
            distortion=np.zeros(5),
            camera_from_robot=pose,
        )
    )
    assert camera.centre_mm == pytest.approx([-11.0, -5.0, 2.0])
    # 100 mm in front of the camera, which looks along the robot's +X; 10 mm along its own x, the robot's +Y
    assert camera.project(np.array([[89.0, 5.0, 2.0]])) == pytest.approx(np.array([[40.0, 20.0]]))
    assert camera.rays(np.array([[30.0, 20.0]]))[0] == pytest.approx([1.0, 0.0, 0.0])


def test_integer_coordinates_are_pixel_centres():
    picture = np.full((40, 60), 200, np.uint8)
    picture[20, 30] = 10
    at = np.array([[30.0, 20.0], [30.5, 20.0], [31.0, 20.0]])
    here = Walk(np.zeros((3, 1), np.float32), np.ones(3))
    seen = contrast(picture, np.full_like(picture, 200), at, np.zeros_like(at), here)[:, 0]
    full = LINEAR[200] - LINEAR[10]
    assert seen[0] == pytest.approx(full)
    assert 0 < seen[1] < full
    assert seen[2] == 0
