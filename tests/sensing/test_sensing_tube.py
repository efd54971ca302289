"""Where cameras see a tube's sides and end: held against the geometry of cylinders, spheres and disks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.geometry import curve
from sensing.geometry.vectors import cross, inner, lengths, median
from sensing.refined.tube import END_LINES, Curve, Tip, end, sides

RADIUS_MM = 3.0
LENGTH_MM = 80.0


def leaning(angle_rad=0.0, heading_rad=0.0):
    """A straight tube from the origin."""
    along = np.array(
        [np.sin(angle_rad) * np.cos(heading_rad), np.sin(angle_rad) * np.sin(heading_rad), np.cos(angle_rad)]
    )
    parameter = np.linspace(0, 1, 40)
    control = curve.fit_points(parameter[:, None] * LENGTH_MM * along, parameter)
    return Curve(control, LENGTH_MM, np.full(curve.SAMPLES, RADIUS_MM)), along


places = st.tuples(st.floats(-200, 200), st.floats(-300, -120), st.floats(-50, 150)).map(np.array)
angles = st.floats(0, 1.2)


@given(places, angles, st.floats(-3, 3))
def test_sides_are_where_sights_touch_the_tube(camera_mm, angle_rad, heading_rad):
    tube, along = leaning(angle_rad, heading_rad)
    seen = sides(camera_mm[None], tube)
    for edge in (seen.one[0], seen.other[0]):
        from_axis = edge - inner(edge, along) * along
        assert lengths(from_axis)[:, 0] == pytest.approx(np.full(curve.SAMPLES, RADIUS_MM), rel=1e-3)
        touching = inner(edge - camera_mm, from_axis)[:, 0] / RADIUS_MM / lengths(edge - camera_mm)[:, 0]
        assert np.abs(touching).max() < 2e-3


@given(places, angles, st.floats(-3, 3))
def test_a_round_ends_outline_lies_on_its_half_sphere_and_a_flat_ones_on_its_face(
    camera_mm, angle_rad, heading_rad
):
    tube, along = leaning(angle_rad, heading_rad)
    tip = LENGTH_MM * along
    ball = end(camera_mm[None], tube, Tip.ROUND).outline[0] - (tip - RADIUS_MM * along)
    assert lengths(ball)[:, 0] == pytest.approx(np.full(len(END_LINES), RADIUS_MM), rel=1e-3)
    face = end(camera_mm[None], tube, Tip.FLAT).outline[0] - tip
    assert lengths(face).max() < RADIUS_MM * 1.001


def test_the_search_for_the_end_begins_at_the_same_place_inside_for_both_tips():
    tube, along = leaning(0.4, 1.0)
    camera_mm = np.array([[90.0, -190.0, 40.0]])
    starts = [end(camera_mm, tube, tip).inside[0] @ along for tip in Tip]
    assert starts[0] == pytest.approx(starts[1], abs=0.1)
    assert (starts[0] < LENGTH_MM - RADIUS_MM).all()


def test_a_round_tips_end_moves_with_the_half_spheres_centre():
    tube, _ = leaning()
    basis = end(np.array([[0.0, -200.0, 40.0]]), tube, Tip.ROUND).basis
    assert (basis @ tube.control_mm)[2] == pytest.approx(LENGTH_MM - RADIUS_MM, abs=0.01)


@given(st.integers(0, 10**6), st.integers(1, 60))
def test_products_of_vectors_are_numpys(seed, count):
    random = np.random.default_rng(seed)
    first, second = random.normal(size=(2, 3, count, 3))
    assert cross(first, second) == pytest.approx(np.cross(first, second))
    assert cross(first[0, 0], second) == pytest.approx(np.cross(first[0, 0], second))
    assert inner(first, second)[..., 0] == pytest.approx((first * second).sum(axis=-1))
    assert lengths(first)[..., 0] == pytest.approx(np.linalg.norm(first, axis=-1))
    odd = random.normal(size=2 * count + 1)
    assert median(odd) == pytest.approx(np.median(odd))
