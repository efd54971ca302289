"""A curve that one camera sees folded, from another camera's midline."""

import cv2
import numpy as np
import pytest

from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.refined.tube import Curve
from sensing.refined.tube_mask import tube_mask, widened
from sensing.refined.unfolding import unfolded

BASE = np.zeros(3)


@pytest.fixture(scope="module")
def cameras(rig):
    return [Camera(calibration) for calibration in rig]


def tube(points_mm):
    """The tube along points (n, 3)."""
    return Curve(
        curve.fit_points(points_mm, np.linspace(0, 1, len(points_mm))), 80.0, np.full(curve.SAMPLES, 3.0)
    )


def seen_by(camera, points_mm):
    mask, _ = tube_mask(camera, tube(points_mm), Grid.of(camera.size_px))
    return camera, mask


def farthest_mm(points, truth):
    """How far the worst of the points is from a line."""
    dense = curve.resample(truth, 2000)
    return np.linalg.norm(points[:, None] - dense[None], axis=2).min(axis=1).max()


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0, 0.0), (0.8, 0.6, 0.5, 2.0), (0.9, 3.0, 0.9, 0.5)])
@pytest.mark.parametrize("along", [0, 1])
def test_points_lie_on_the_robot(cameras, arcs, pose, along):
    truth = arcs(*pose)
    camera, other = cameras[along], cameras[1 - along]
    line = curve.resample(camera.project(truth), 60)
    points = unfolded(camera, line, [seen_by(other, truth)], BASE, 80.0)
    assert np.abs(camera.project(points) - line).max() < 1e-6
    assert farthest_mm(points, truth) < 6.0


def test_a_robot_that_folds_over_itself_in_the_other_camera_is_followed_to_its_tip(cameras, arcs):
    towards = cameras[1].centre_mm
    truth = arcs(
        1.4, float(np.arctan2(towards[1], towards[0])), 1.4, float(np.arctan2(towards[1], towards[0]))
    )
    line = curve.resample(cameras[0].project(truth), 60)
    points = unfolded(cameras[0], line, [seen_by(cameras[1], truth)], BASE, 80.0)
    assert np.linalg.norm(points[-1] - truth[-1]) < 6.0


def test_the_widened_tube_has_a_rim(cameras, arcs):
    mask, half_width = tube_mask(cameras[0], tube(arcs()), Grid.of(cameras[0].size_px))
    wider = widened(mask, 0.5 * half_width)
    assert 1.3 < np.count_nonzero(wider) / np.count_nonzero(mask) < 1.8
    assert not (mask & ~wider).any()
    assert half_width == pytest.approx(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max(), abs=1.0)
