"""What a quick look around a fitted tube sees, and what it does not mistake for the robot."""

import cv2
import numpy as np
import pytest

from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.segmentation import Limits
from sensing.refined.lookout import look_around
from sensing.refined.measuring import View
from sensing.refined.tube import Curve

RADIUS_MM = 3.0
POSE = (0.8, 0.6, 0.5, 2.0)
ROBOT = 70


@pytest.fixture(scope="module")
def camera(rig):
    return Camera(rig[0])


def tube(points_mm):
    """The curve through points (n, 3)."""
    share = np.linspace(0, 1, len(points_mm))
    return Curve(curve.fit_points(points_mm, share), 80.0, np.full(curve.SAMPLES, RADIUS_MM))


def picture(camera, points_mm, seed=1):
    """A dark tube on its holder before a grey backdrop, by its projected line alone; and the backdrop."""
    empty = np.full(camera.size_px[::-1], 150.0)
    seen = empty.copy()
    _, jacobian = camera.project_with_jacobian(points_mm[:1])
    width = round(2 * RADIUS_MM * float(np.linalg.svd(jacobian[0], compute_uv=False)[0]))
    pixels = camera.project(points_mm).round().astype(np.int32)
    cv2.polylines(seen, [pixels], isClosed=False, color=ROBOT, thickness=width)
    x, y = pixels[0]
    seen[y:, x - 60 : x + 60] = ROBOT
    noise = np.random.default_rng(seed).normal(0, 2, seen.shape)
    return np.clip(seen + noise, 0, 255).astype(np.uint8), empty.astype(np.uint8)


def look(camera, points_mm, seen, empty, **limits):
    view = View(camera, seen, empty, np.zeros(2))
    return look_around(view, tube(points_mm), 0.0, Limits(**({"holder_radius_mm": 25.0} | limits)))


@pytest.mark.parametrize("pose", [(), POSE, (1.6, 0.0, 1.4, 3.1), (0.3, 1.57, 0.3, 1.57)])
def test_a_tube_that_explains_the_picture_is_no_surprise(camera, arcs, pose):
    points = arcs(*pose)
    seen = look(camera, points, *picture(camera, points))
    assert seen.explained > 0.95
    assert seen.elsewhere < 0.1
    assert not seen.surprising


@pytest.mark.parametrize("moved_mm", [6.0, 12.0])
def test_a_tube_beside_the_robot_is_a_surprise(camera, arcs, moved_mm):
    points = arcs(*POSE)
    assert look(camera, points + np.array([moved_mm, 0, 0]), *picture(camera, points)).surprising


def test_a_robot_that_bent_away_is_a_surprise(camera, arcs):
    seen, empty = picture(camera, arcs(0.8, 0.6, 1.8, 0.0))
    assert look(camera, arcs(*POSE), seen, empty).surprising


def test_nothing_where_the_tube_is_supposed_to_be_is_a_surprise(camera, arcs):
    _, empty = picture(camera, arcs())
    look_at = look(camera, arcs(), empty, empty)
    assert look_at.explained == 0
    assert look_at.surprising


def beside(camera, points_mm, seen, length_px, thickness_px):
    """The picture with something more in it that touches the robot's middle."""
    x, y = camera.project(points_mm[40:41])[0].round().astype(int)
    return cv2.line(seen.copy(), (x, y), (x + length_px, y), ROBOT, thickness_px)


def test_something_as_thick_as_the_robot_that_touches_it_is_a_surprise(camera, arcs):
    points = arcs(*POSE)
    seen, empty = picture(camera, points)
    assert look(camera, points, beside(camera, points, seen, 150, 40), empty).surprising


def test_thin_things_specks_and_what_stands_apart_are_not(camera, arcs):
    points = arcs(*POSE)
    seen, empty = picture(camera, points)
    seen = beside(camera, points, seen, 150, 8)
    x, y = camera.project(points[60:61])[0].round().astype(int)
    seen[y - 9 : y + 9, x - 75 : x - 60] = ROBOT
    seen[y - 100 : y + 60, x + 110 : x + 140] = ROBOT
    assert not look(camera, points, seen, empty).surprising


def test_what_lies_outside_of_the_work_area_is_not_looked_at(camera, arcs):
    points = arcs()
    seen, empty = picture(camera, points)
    x, _ = camera.project(points[40:41])[0].round()
    seen = beside(camera, points, seen, 150, 40)
    area = np.array([[x - 60, 0], [x + 40, 0], [x + 40, 1079], [x - 60, 1079]])
    assert look(camera, points, seen, empty).surprising
    assert not look(camera, points, seen, empty, work_area=area).surprising


def test_a_part_of_the_picture_shows_the_same(camera, arcs):
    points = arcs(*POSE)
    seen, empty = picture(camera, points)
    pixels = camera.project(points)
    left, top = (pixels.min(axis=0) - 200).astype(int)
    right, bottom = (pixels.max(axis=0) + 200).astype(int)
    part = np.s_[top:bottom, left:right]
    view = View(camera, seen[part], empty[part], np.array([left, top], dtype=np.float64))
    assert look_around(view, tube(points), 0.0, Limits(25.0)) == look(camera, points, seen, empty)


def test_a_tube_out_of_the_picture_is_a_surprise(camera, arcs):
    seen, empty = picture(camera, arcs())
    assert look(camera, arcs() + np.array([500.0, 0, 0]), seen, empty).surprising
