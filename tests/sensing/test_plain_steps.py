"""The plain method's steps one by one: each a pure function with a truth of its own."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import BaseView
from sensing.plain.judging import loses_its_way
from sensing.plain.line import line_through, to_silhouettes_end
from sensing.plain.order import end_of_line, ordered
from sensing.plain.pairing import all_pairs, descended
from sensing.plain.polyline import Polyline
from sensing.plain.silhouette import (
    area_opened,
    closed,
    colour_distance,
    joined_to_base,
    reaches_rim,
    silhouette,
    without_holder,
)
from sensing.plain.skeleton import skeleton
from sensing.plain.trace import Trace

HEIGHT, WIDTH = 120, 160


def drawn(*strokes, thickness=21):
    """A mask (120, 160) of lines through (x, y) corners."""
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for corners in strokes:
        cv2.polylines(mask, [np.array(corners, np.int32)], isClosed=False, color=255, thickness=thickness)
    return mask


# equation 1, cleaning, the part at the base


@given(st.lists(st.integers(0, 255), min_size=6, max_size=6))
def test_colour_distance_is_equation_1_squared(levels):
    seen, empty = np.array(levels, np.uint8).reshape(2, 1, 1, 3)
    expected = np.sum((seen.astype(float) - empty.astype(float)) ** 2)
    assert colour_distance(seen, empty)[0, 0] == pytest.approx(expected)


def test_area_opening_drops_small_objects_and_keeps_large_ones_as_they_are():
    mask = drawn([(80, 10), (80, 100)])
    speckled = mask.copy()
    speckled[5:8, 5:8] = 255
    assert (area_opened(speckled, 10) == mask).all()
    assert (area_opened(speckled, 9) == speckled).all()


def test_closing_fills_gaps_and_moves_no_straight_border():
    mask = drawn([(80, 10), (80, 100)])
    holed = mask.copy()
    holed[50:55, 76:84] = 0
    assert (closed(holed, 4) == closed(mask, 4)).all()
    assert (closed(mask, 4)[20:90] == mask[20:90]).all()


def base_at(x, y):
    return BaseView(
        np.array([x, y], float), np.array([[x, y - 10], [x, y - 20]], float), np.array([0.0, -1.0]), 5.0
    )


def test_the_holder_ends_where_the_robot_begins():
    mask = without_holder(drawn([(80, 10), (80, 119)]), base_at(80, 90), radius_mm=10)
    assert mask[:89, 80].all()
    assert not mask[92:].any()


def test_only_what_is_joined_to_the_base_is_robot():
    mask = joined_to_base(
        drawn([(80, 10), (80, 100)], [(20, 10), (20, 100)]), base_at(80, 90).axis_in("left", (120, 160))
    )
    assert (mask == drawn([(80, 10), (80, 100)])).all()
    assert not joined_to_base(drawn([(20, 10), (20, 100)]), base_at(80, 90).axis_in("left", (120, 160))).any()


def test_a_silhouette_that_leaves_the_picture_or_the_work_area_is_noticed():
    area = np.array([[30.0, 5.0], [130.0, 5.0], [130.0, 110.0], [30.0, 110.0]])
    inside = drawn([(80, 30), (80, 90)])
    assert not reaches_rim(inside, None)
    assert not reaches_rim(inside, area)
    assert reaches_rim(drawn([(80, 30), (80, 119)]), None)
    assert reaches_rim(drawn([(80, 30), (30, 60)]), area)
    assert not reaches_rim(drawn([(80, 30), (30, 60)]), None)


def test_a_threshold_that_takes_the_backdrop_for_robot_is_refused(rig):
    camera = Camera(rig[0])
    backdrop = np.full((1080, 1920, 3), 120, np.uint8)
    base = BaseView.of(camera, 0.0, Grid(camera.size_px, 1))
    with pytest.raises(
        RefusedError, match=r"camera left: 100 % of the picture stand out .*threshold 5 levels"
    ):
        silhouette(
            camera,
            backdrop + np.uint8(9),
            backdrop,
            base,
            holder_radius_mm=25,
            work_area=None,
            threshold=5,
        )


def test_a_base_outside_of_the_picture_is_refused(rig):
    with pytest.raises(RefusedError, match="camera left: the robot's base is outside the picture"):
        BaseView.of(Camera(rig[0]), 500.0).axis_in("left", (540, 960))


# the skeleton


def test_a_straight_tubes_skeleton_is_its_middle_and_ends_a_half_width_early():
    found = skeleton(drawn([(80, 20), (80, 100)], thickness=21), np.array([80.0, 110.0]))
    assert np.abs(found.pixels[:, 0] - 80).max() <= 1
    assert found.half_width_px == pytest.approx(11, abs=1.5)
    assert found.pixels[0, 1] > 95
    assert found.pixels[-1, 1] == pytest.approx(20, abs=5)
    assert np.diff(found.reach_px).min() > 0


@given(
    x=st.integers(40, 120), across=st.integers(-35, 35), disk=st.integers(0, 4), thickness=st.integers(13, 25)
)
@settings(max_examples=30, deadline=None)
def test_disks_and_corners_make_no_branches(x, across, disk, thickness):
    top = np.array([x + across, 25])
    mask = drawn([(x, 105), tuple(top)], thickness=thickness)
    middle = (np.array([x, 105]) + top) / 2
    side = np.array([1.0, 0.0]) * (thickness / 2 + disk)
    cv2.line(mask, tuple((middle - side).astype(int)), tuple((middle + side).astype(int)), 255, 4)
    found = skeleton(mask, np.array([x, 115.0]))
    ends = sum(1 for pixel in found.pixels if (np.abs(found.pixels - pixel).max(axis=1) == 1).sum() == 1)
    assert ends == 2
    onwards = (top - [x, 105]) / np.linalg.norm(top - [x, 105])
    offset = (found.pixels - [x, 105]) @ np.array([-onwards[1], onwards[0]])
    assert np.abs(offset).max() < 3.5
    assert found.reach_px[-1] > 0.6 * np.linalg.norm(top - [x, 105])


def test_a_real_branch_stays():
    found = skeleton(
        drawn([(80, 110), (80, 60), (30, 20)], [(80, 60), (130, 20)], thickness=13), np.array([80.0, 119.0])
    )
    far = found.pixels[found.reach_px > found.reach_px.max() - 8]
    assert far[:, 0].min() < 50
    assert far[:, 0].max() > 110


def test_pixels_are_reached_along_the_skeleton():
    found = skeleton(
        drawn([(30, 110), (30, 20), (130, 20), (130, 110)], thickness=13), np.array([30.0, 118.0])
    )
    steps = np.linalg.norm(found.pixels[1:] - found.pixels[list(found.parent[1:])], axis=1)
    assert steps.max() < 1.5
    assert found.pixels[-1] == pytest.approx([130, 108], abs=6)
    assert all(here in found.near[there] for here, near in enumerate(found.near) for there in near)


# pairing


def straight(count):
    """The skeleton of a straight vertical tube of so many px."""
    mask = np.zeros((count + 30, 40), np.uint8)
    mask[10 : count + 20, 12:28] = 255
    return skeleton(mask, np.array([20.0, count + 30.0]))


@given(st.integers(40, 90), st.floats(-8, 8))
@settings(max_examples=20, deadline=None)
def test_descent_finds_the_least_gap_where_there_is_one_minimum(count, shift):
    first, second = straight(60), straight(count)
    gaps = np.abs(first.reach_px[:, None] + shift - second.reach_px[None])
    found = descended(gaps, first, second)
    assert [gaps[row, column] for row, column in enumerate(found)] == pytest.approx(gaps.min(axis=1))


def test_descent_goes_on_from_the_pair_before_and_does_not_jump():
    """A second, deeper minimum far away is not looked at: that is the method's strength and its fault."""
    first = second = straight(80)
    near = np.abs(first.reach_px[:, None] - second.reach_px[None])
    trap = np.abs(second.reach_px[None] - 70) - 5.0
    found = descended(np.minimum(near, trap + 0 * near)[:30], first_of(first, 30), second)
    assert np.abs(second.reach_px[found] - first.reach_px[:30]).max() < 1


def test_descent_begins_where_the_pair_before_ended():
    """From the beginning each time it would be caught by what lies there."""
    first = second = straight(80)
    near = np.abs(first.reach_px[:, None] - second.reach_px[None])
    beginning = np.abs(second.reach_px[None] - 2) + 3.0
    found = descended(np.minimum(near, beginning), first, second)
    assert np.abs(second.reach_px[found] - first.reach_px).max() < 1


def first_of(whole, count):
    """The beginning of a skeleton."""
    return type(whole)(
        pixels=whole.pixels[:count],
        parent=whole.parent[:count],
        reach_px=whole.reach_px[:count],
        near=tuple(tuple(other for other in near if other < count) for near in whole.near[:count]),
        depth_px=whole.depth_px[:count],
        half_width_px=whole.half_width_px,
    )


def test_all_pixels_of_both_are_paired_and_no_pair_stands_twice():
    first, second = straight(50), straight(80)
    gaps = np.abs(first.reach_px[:, None] - 0.6 * second.reach_px[None])
    pairs = all_pairs(gaps, first, second)
    assert set(pairs[:, 0]) == set(range(len(first.pixels)))
    assert set(pairs[:, 1]) == set(range(len(second.pixels)))
    assert len({tuple(pair) for pair in pairs.tolist()}) == len(pairs)


# order


@given(st.permutations(range(40)))
@settings(max_examples=30)
def test_points_come_out_in_order_whatever_order_they_came_in(shuffled):
    angle = np.linspace(0, 1.2, 40)
    points = 50 * np.column_stack([1 - np.cos(angle), 0 * angle, np.sin(angle)])
    found = ordered(points[shuffled], 0.1)
    assert np.array(shuffled)[found].tolist() == list(range(40))


def test_duplicates_are_dropped_and_nothing_else():
    line = np.column_stack([np.zeros((30, 2)), np.arange(30.0)])
    noisy = np.vstack([line, line + np.array([0.05, 0, 0.05])])
    assert len(ordered(noisy, 0.5)) == 30
    taken = noisy[ordered(noisy, 2.0)]
    assert np.linalg.norm(np.diff(taken, axis=0), axis=1).min() > 2.0
    assert np.diff(taken[:, 2]).min() > 0


def test_a_line_ends_with_its_last_point_and_not_with_one_beside_it():
    line = np.column_stack([np.zeros((30, 2)), np.arange(30.0) / 5])
    stray = np.array([[1.5, 0.0, 7.5]])
    points = np.vstack([line, stray])
    taken = np.array([0, 10, 25])
    assert end_of_line(points, taken, 3.0) == 29


# the line


def test_a_polyline_measures_along_its_pieces():
    line = Polyline(np.array([[0.0, 0, 0], [0, 0, 10], [0, 10, 10]]), np.zeros((3, 3, 3)))
    places, _ = line.at(np.array([0.0, 4.0, 15.0, 22.0]))
    assert places.tolist() == [[0, 0, 0], [0, 0, 4], [0, 5, 10], [0, 12, 10]]
    assert line.arc_mm.tolist() == [0, 10, 20]


def test_beyond_the_tip_the_line_goes_straight_on_and_knows_less():
    covariance = np.tile(0.01 * np.eye(3), (2, 1, 1))
    line = Polyline(np.array([[0.0, 0, 0], [0, 0, 10]]), covariance)
    _, spread = line.at(np.array([5.0, 10.0, 12.0]))
    assert spread[:2] == pytest.approx(covariance)
    assert spread[2, 0, 0] > 0.02
    assert spread[2, 2, 2] == pytest.approx(0.01)


def test_a_line_begins_at_the_base_and_leaves_it_upwards(rig):
    angle = np.linspace(0.2, 1.0, 10)
    points = 60 * np.column_stack([1 - np.cos(angle), 0 * angle, np.sin(angle)]) + np.array([0, 0, 5])
    line = line_through(points, 5.0, 3.0, tuple(map(Camera, rig)))
    assert line.points_mm[0].tolist() == [0, 0, 5]
    fine = 60 * np.column_stack([1 - np.cos(angle[0] / 2), 0, np.sin(angle[0] / 2)])[0] + [0, 0, 5]
    middle, _ = line.at(np.array([angle[0] / 2 * 60]))
    assert middle[0] == pytest.approx(fine, abs=0.1)
    assert line.arc_mm[-1] == pytest.approx(63, abs=0.3)


def test_a_stretch_along_the_epipolar_direction_knows_less_of_its_depth(rig):
    cameras = tuple(map(Camera, rig))
    upright = np.column_stack([np.zeros((8, 2)), np.linspace(10, 70, 8)])
    baseline = cameras[1].centre_mm - cameras[0].centre_mm
    lying = np.array([0, 0, 58.0]) + np.linspace(-30, 30, 8)[:, None] * baseline / np.linalg.norm(baseline)
    spread = [
        np.sqrt(np.linalg.eigvalsh(line_through(points, 0.0, 1.0, cameras).covariance_mm2[3:-3]).max())
        for points in (upright, lying)
    ]
    assert spread[0] < 0.6
    assert spread[1] > 5


def test_the_line_ends_where_the_silhouettes_end(rig, project):
    cameras = tuple(map(Camera, rig))
    points = np.column_stack([np.zeros((10, 2)), np.linspace(6, 60, 10)])
    masks = []
    for calibration in rig:
        pixels = project(calibration, [[0, 0, 0], [0, 0, 64.0]]).round().astype(int)
        mask = np.zeros((1080, 1920), np.uint8)
        masks.append(cv2.rectangle(mask, pixels[0] - [20, 0], pixels[1] + [20, 0], 255, -1))
    assert to_silhouettes_end(points, 3.0, cameras, tuple(masks)) == pytest.approx(4.0, abs=0.2)


def trace_along(corners_mm, walk_px):
    """A trace of a robot with a radius of 3 mm."""
    line = Polyline(np.array(corners_mm, float), np.zeros((len(corners_mm), 3, 3)))
    walk = np.column_stack([walk_px, walk_px]).astype(float)
    return Trace(line, (), np.zeros((0, 3)), np.zeros(0), walk, radius_mm=3.0, insertion_mm=0.0)


@pytest.mark.parametrize(
    ("corners_mm", "walk_px", "lost"),
    [
        ([[0, 0, 0], [0, 0, 4], [0, 1, 8], [0, 2, 12]], [0, 25, 50], False),
        ([[0, 0, 0], [0, 0, 4], [4, 0, 4], [4, 0, 8]], [0, 25, 50], True),
        ([[0, 0, 0], [0, 0, 4], [0, 0, 20], [0, 0, 24]], [0, 25, 50], True),
        ([[0, 0, 0], [0, 0, 4], [0, 1, 8], [0, 2, 12]], [0, 25, 20], True),
        ([[0, 0, 0], [0, 0, 4], [0, 1, 8], [0, 2, 12]], [0, 25, 26], True),
    ],
    ids=["as it should", "a corner", "a leap", "backwards", "on the spot"],
)
def test_a_line_that_no_tube_can_follow_has_lost_its_way(corners_mm, walk_px, lost):
    assert loses_its_way(trace_along(corners_mm, walk_px), half_width_px=20.0) is lost


def test_arc_lengths_of_a_polyline_are_the_curves(arcs):
    line = Polyline(arcs(0.8, 0.3, 0.9, 1.0), np.zeros((81, 3, 3)))
    assert line.arc_mm[-1] == pytest.approx(80, abs=0.02)
    assert line.tangents[0] == pytest.approx([0, 0, 1], abs=0.02)
    assert curve.arc_lengths(line.points_mm) == pytest.approx(line.arc_mm)
