"""The fitted tube as a camera sees it."""

import cv2
import numpy as np
import pytest

from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.refined.tube import Curve
from sensing.refined.tube_mask import tube_mask, widened


def tube(points_mm):
    """The tube along points (n, 3)."""
    share = np.linspace(0, 1, len(points_mm))
    return Curve(curve.fit_points(points_mm, share), 80.0, np.full(curve.SAMPLES, 3.0))


@pytest.mark.parametrize("step", [1, 2, 8])
def test_the_tube_lies_around_its_projected_line(rig, arcs, project, step):
    camera, grid, truth = Camera(rig[0]), Grid((1920, 1080), step), arcs(0.8, 0.6, 0.5, 2.0)
    mask, half_width = tube_mask(camera, tube(truth), grid)
    inner = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    x, y = grid.coarse(project(rig[0], truth[5:-5])).round().astype(int).T
    assert mask.shape == grid.shape
    assert half_width == pytest.approx(np.median(inner[y, x]), abs=1.0)


def test_a_part_of_the_picture_shows_a_part_of_the_tube(rig, arcs):
    camera, truth = Camera(rig[1]), arcs(0.5, 0.0, 0.9, 1.0)
    whole, _ = tube_mask(camera, tube(truth), Grid((1920, 1080), 1))
    part, _ = tube_mask(camera, tube(truth), Grid((300, 200), 1), np.array([900.0, 500.0]))
    assert part.any()
    assert np.count_nonzero(part != whole[500:700, 900:1200]) < 0.005 * part.size


def test_the_widened_tube_has_a_rim(rig, arcs):
    mask, half_width = tube_mask(Camera(rig[0]), tube(arcs()), Grid((1920, 1080), 2))
    wider = widened(mask, 0.5 * half_width)
    assert 1.3 < np.count_nonzero(wider) / np.count_nonzero(mask) < 1.8
    assert not (mask & ~wider).any()


def test_a_tube_far_out_of_the_picture_is_not_drawn(rig, arcs):
    mask, _ = tube_mask(Camera(rig[0]), tube(arcs() + np.array([1e4, 0, 0])), Grid((1920, 1080), 2))
    assert not mask.any()
