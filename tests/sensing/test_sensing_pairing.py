"""Pairing of two midlines, and triangulation: literal values, brute force, and a curve that defeats the greedy way."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drivers.simulated.cameras.rig import default_cameras
from messaging.frames import CameraCalibration
from sensing.geometry.camera import Camera
from sensing.geometry.curve import resample
from sensing.geometry.rays import ray_gaps, triangulate
from sensing.refined.walk import EVENNESS_MM2, ordered_pairs

LEFT, RIGHT = map(Camera, default_cameras())
coordinate = st.floats(-60, 60)
places = st.tuples(coordinate, coordinate, st.floats(-20, 110)).map(np.array)


def standing_at(x, y, z, name="camera"):
    """A camera at a place in the robot frame, looking along +Z."""
    pose = np.eye(4)
    pose[:3, 3] = [-x, -y, -z]
    intrinsics = np.array([[1000.0, 0, 500], [0, 1000, 400], [0, 0, 1]])
    return Camera(
        CameraCalibration(
            camera=name,
            width_px=1000,
            height_px=800,
            intrinsics=intrinsics,
            distortion=np.zeros(5),
            camera_from_robot=pose,
        )
    )


def test_the_gap_between_two_rays_is_their_shortest_distance():
    first, second = standing_at(0, 0, 0), standing_at(100, 4, 50)
    upwards, leftwards, slanted = (
        np.array([[0.0, 0, 1]]),
        np.array([[-1.0, 0, 0]]),
        np.array([[-0.6, 0, 0.8]]),
    )
    # the Z axis, and a line 4 mm beside it
    assert ray_gaps(first, upwards, second, np.vstack([leftwards, slanted])) == pytest.approx(
        np.array([[4.0, 4.0]])
    )
    point, gap = triangulate(first, upwards, second, leftwards)
    assert point[0] == pytest.approx([0.0, 2.0, 50.0])
    assert gap[0] == pytest.approx(4.0)
    # the slanted line climbs 4 mm for every 3 mm that it goes back
    point, gap = triangulate(first, upwards, second, slanted)
    assert point[0] == pytest.approx([0.0, 2.0, 50 + 400 / 3])
    assert gap[0] == pytest.approx(4.0)


def test_parallel_rays_give_finite_numbers():
    first, second = standing_at(0, 0, 0), standing_at(100, 0, 0)
    upwards = np.array([[0.0, 0, 1]])
    assert np.isfinite(ray_gaps(first, upwards, second, upwards)).all()
    assert all(np.isfinite(numbers).all() for numbers in triangulate(first, upwards, second, upwards))


@given(places)
def test_exact_rays_give_the_exact_point(point_mm):
    rays = [camera.rays(camera.project(point_mm[None])) for camera in (LEFT, RIGHT)]
    point, gap = triangulate(LEFT, rays[0], RIGHT, rays[1])
    assert point[0] == pytest.approx(point_mm, abs=1e-5)
    assert gap[0] < 1e-5
    assert ray_gaps(LEFT, rays[0], RIGHT, rays[1])[0, 0] < 1e-5


gap_tables = arrays(
    np.float64,
    st.tuples(st.integers(1, 5), st.integers(1, 5)),
    elements=st.floats(0, 10, allow_subnormal=False),
)


def cheapest(cost):
    """The cost of the cheapest monotone walk, by trying them all."""
    rows, columns = cost.shape

    def onwards(i, j):
        if (i, j) == (rows - 1, columns - 1):
            return cost[i, j]
        moves = [(i + 1, j + 1), (i + 1, j), (i, j + 1)]
        return cost[i, j] + min(onwards(*move) for move in moves if move[0] < rows and move[1] < columns)

    return onwards(0, 0)


@given(gap_tables)
def test_the_walk_is_monotone_from_end_to_end_and_none_is_cheaper(gaps):
    first, second = ordered_pairs(gaps)
    assert (first[0], second[0]) == (0, 0)
    assert (first[-1], second[-1]) == (gaps.shape[0] - 1, gaps.shape[1] - 1)
    steps = list(zip(np.diff(first).tolist(), np.diff(second).tolist(), strict=True))
    assert set(steps) <= {(1, 1), (1, 0), (0, 1)}
    cost = gaps**2 + EVENNESS_MM2
    assert cost[first, second].sum() == pytest.approx(cheapest(cost))


def test_order_finds_the_pairs_where_the_smallest_gap_jumps():
    """An arch meets most epipolar lines of two cameras side by side twice."""
    first, second = standing_at(-60, 0, -200), standing_at(60, 0, -200)
    angle = np.linspace(0, 2.6, 1001)
    arch = np.column_stack([18 - 30 * np.cos(angle), -30 * np.sin(angle), 8 * np.sin(2 * angle)])
    truth = resample(arch, 100)
    midlines = [resample(camera.project(arch), 100) for camera in (first, second)]
    rng = np.random.default_rng(5)
    rays = [
        camera.rays(line + rng.normal(0, 0.05, line.shape))
        for camera, line in zip((first, second), midlines, strict=True)
    ]
    gaps = ray_gaps(first, rays[0], second, rays[1])

    def farthest(i, j):
        points, _ = triangulate(first, rays[0][i], second, rays[1][j])
        fine = resample(arch, 4000)
        return max(float(np.linalg.norm(fine - point, axis=1).min()) for point in points)

    i, j = ordered_pairs(gaps)
    greedy = np.arange(100), gaps.argmin(axis=1)
    assert farthest(*greedy) > 10.0
    assert max(abs(after - before) for before, after in pairwise(greedy[1].tolist())) > 20
    assert farthest(i, j) < 1.5
    assert np.abs(i - j).max() <= 8
    middle, _ = triangulate(first, rays[0][i], second, rays[1][j])
    assert np.linalg.norm(middle[len(middle) // 2] - truth[50]) < 1.5
