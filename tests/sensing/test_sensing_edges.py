"""Edges of a synthetic bar, blurred in linear light, at known places between pixels."""

import numpy as np
import pytest
from scipy.special import erf

from sensing.pictures.light import LINEAR
from sensing.refined.edges import Walk, contrast, edge_pairs, ends

HEIGHT, WIDTH = 120, 200
MIDDLE = np.array([100.0, 60.0])
BACKDROP = 150.0


def step(distance_px, blur_px):
    return (1 + erf(distance_px / (np.sqrt(2) * blur_px))) / 2


@pytest.fixture
def bar(to_light, to_levels):
    """A picture of an endless bar of linear light mixed with the backdrop's, and the backdrop.

    `across` runs through the bar; its edges lie at -half_width + offset and half_width + offset from MIDDLE.
    """

    def _bar(offset_px, half_width_px, angle_deg=90.0, blur_px=1.0, sides=(60.0, 60.0), end_px=None):
        y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
        angle = np.deg2rad(angle_deg)
        along_axis = np.array([np.cos(angle), np.sin(angle)])
        normal = np.array([-along_axis[1], along_axis[0]])
        across = (x - MIDDLE[0]) * normal[0] + (y - MIDDLE[1]) * normal[1] - offset_px
        cover = step(half_width_px - across, blur_px) * step(half_width_px + across, blur_px)
        if end_px is not None:
            along = (x - MIDDLE[0]) * along_axis[0] + (y - MIDDLE[1]) * along_axis[1]
            cover = cover * step(end_px - along, blur_px)
        share = np.clip((across + half_width_px) / (2 * half_width_px), 0, 1)
        inside = to_light(sides[0]) * (1 - share) + to_light(sides[1]) * share
        light = cover * inside + (1 - cover) * to_light(BACKDROP)
        picture = np.rint(to_levels(light)).astype(np.uint8)
        return picture, np.full_like(picture, round(BACKDROP)), normal, along_axis

    return _bar


def find_edges(picture, backdrop, at, normals, half_widths, margin_px=14.0):
    walk = Walk.across(half_widths, np.full(len(at), margin_px))
    return edge_pairs(contrast(picture, backdrop, at, normals, walk), walk, half_widths)


def find_ends(picture, backdrop, starts, directions, reach_px):
    walk = Walk.onwards(reach_px)
    return ends(contrast(picture, backdrop, starts, directions, walk), walk)


def middles(along_axis, count=9):
    """Places along the bar's predicted middle."""
    return MIDDLE + np.linspace(-20, 20, count)[:, None] * along_axis


@pytest.mark.parametrize("angle_deg", [90.0, 0.0, 63.0, 211.0])
@pytest.mark.parametrize("offset_px", [0.0, 0.3, -2.7, 6.45])
@pytest.mark.parametrize("half_width_px", [9.3, 21.6])
def test_edges_are_found_between_pixels(bar, angle_deg, offset_px, half_width_px):
    picture, backdrop, normal, along_axis = bar(offset_px, half_width_px, angle_deg)
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (len(at), 1)), np.full(len(at), half_width_px))
    assert found.valid.all()
    assert found.middle_px == pytest.approx(np.full(len(at), offset_px), abs=0.05)
    assert found.half_width_px == pytest.approx(np.full(len(at), half_width_px), abs=0.1)


@pytest.mark.parametrize("sides", [(200.0, 200.0), (20.0, 20.0)], ids=["brighter", "darker"])
def test_the_robot_may_be_darker_or_brighter_than_the_backdrop(bar, sides):
    picture, backdrop, normal, along_axis = bar(1.2, 12.0, 70.0, sides=sides)
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (len(at), 1)), np.full(len(at), 12.0))
    assert found.valid.all()
    assert found.middle_px == pytest.approx(np.full(len(at), 1.2), abs=0.05)


def test_shading_across_the_tube_does_not_move_its_middle(bar):
    picture, backdrop, normal, along_axis = bar(0.4, 16.0, 80.0, sides=(50.0, 100.0))
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (len(at), 1)), np.full(len(at), 16.0))
    assert found.valid.all()
    assert found.middle_px == pytest.approx(np.full(len(at), 0.4), abs=0.1)


@pytest.mark.parametrize("offset_px", [0.0, 3.4])
def test_a_side_that_hardly_stands_out_is_not_lost_within_the_tube(bar, offset_px):
    """The bright side differs from the backdrop by less than half of what the whole tube does, as a lit flank over a shadow."""
    picture, backdrop, normal, along_axis = bar(offset_px, 16.0, 80.0, sides=(30.0, 128.0))
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (len(at), 1)), np.full(len(at), 16.0))
    assert found.valid.all()
    assert found.half_width_px == pytest.approx(np.full(len(at), 16.0), abs=0.4)
    assert found.middle_px == pytest.approx(np.full(len(at), offset_px), abs=0.4)


def test_half_height_is_half_of_the_light_and_not_of_the_level(bar):
    """Between levels 20 and 150 half of the light is level 110; half of the level would lie 0.3 px further in."""
    picture, backdrop, normal, along_axis = bar(0.0, 14.0, 90.0, blur_px=1.5, sides=(20.0, 20.0))
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (len(at), 1)), np.full(len(at), 14.0))
    assert found.half_width_px == pytest.approx(np.full(len(at), 14.0), abs=0.1)


def test_linear_light_is_that_of_srgb():
    assert LINEAR[0] == 0
    assert LINEAR[255] == pytest.approx(255)
    assert LINEAR[10] == pytest.approx(255 * 10 / 255 / 12.92)
    assert LINEAR[188] == pytest.approx(128.2, abs=0.6)


def test_normals_without_a_bar_do_not_count(bar):
    picture, backdrop, normal, along_axis = bar(0.0, 10.0, 90.0)
    beside = MIDDLE + np.array([[70.0, 0], [-75, 0]])
    found = find_edges(picture, backdrop, beside, np.tile(normal, (2, 1)), np.full(2, 10.0))
    assert not found.valid.any()
    nothing = find_edges(backdrop, backdrop, middles(along_axis), np.tile(normal, (9, 1)), np.full(9, 10.0))
    assert not nothing.valid.any()


def test_a_bar_that_leaves_the_picture_does_not_count(bar):
    picture, backdrop, normal, along_axis = bar(0.0, 110.0, 90.0)
    at = middles(along_axis)
    found = find_edges(picture, backdrop, at, np.tile(normal, (9, 1)), np.full(9, 110.0))
    assert not found.valid.any()


@pytest.mark.parametrize("end_px", [20.0, 20.4, 23.75])
def test_the_end_is_found_between_pixels(bar, end_px):
    picture, backdrop, normal, along_axis = bar(0.0, 14.0, 37.0, end_px=end_px)
    starts = MIDDLE + np.array([[-6.0], [0.0], [6.0]]) * normal
    distance, seen = find_ends(picture, backdrop, starts, np.tile(along_axis, (3, 1)), np.full(3, 45.0))
    assert seen.all()
    assert distance == pytest.approx(np.full(3, end_px), abs=0.05)


def test_an_end_beyond_reach_is_not_seen(bar):
    picture, backdrop, _, along_axis = bar(0.0, 14.0, 0.0)
    _, seen = find_ends(picture, backdrop, MIDDLE[None], along_axis[None], np.array([45.0]))
    assert not seen.any()
