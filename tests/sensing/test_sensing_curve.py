"""The spline of the centreline, and lengths along lines of points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.geometry import curve

parameters = st.lists(st.floats(0, 1), min_size=1, max_size=30).map(np.array)


@given(parameters)
def test_the_basis_is_a_partition_of_unity(parameter):
    basis = curve.basis(parameter)
    assert basis.shape == (len(parameter), curve.CONTROL_POINTS)
    assert (basis >= -1e-12).all()
    assert basis.sum(axis=1) == pytest.approx(np.ones(len(parameter)))


@given(st.floats(0.01, 0.99))
def test_the_first_derivative_is_the_slope(parameter):
    control = np.random.default_rng(1).normal(size=curve.CONTROL_POINTS)
    step = 1e-6
    after, before = (curve.basis(np.array([parameter + side])) @ control for side in (step, -step))
    slope = curve.basis(np.array([parameter]), 1) @ control
    assert slope == pytest.approx((after - before) / (2 * step), abs=1e-4)


def test_the_curve_begins_at_the_first_control_point_and_ends_at_the_last():
    control = np.random.default_rng(2).normal(size=(curve.CONTROL_POINTS, 3))
    points = curve.POSITION @ control
    assert points[0] == pytest.approx(control[0])
    assert points[-1] == pytest.approx(control[-1])


def test_arc_lengths_add_up():
    points = np.array([[0.0, 0, 0], [3, 4, 0], [3, 4, 12], [3, 4, 12]])
    assert curve.arc_lengths(points).tolist() == [0.0, 5.0, 17.0, 17.0]


def test_resampling_keeps_the_ends_and_evens_the_steps():
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    assert curve.resample(corner, 5).tolist() == [[0, 0], [2, 0], [4, 0], [4, 2], [4, 4]]


@pytest.mark.parametrize("bend", [(0.0, 0.0, 0.0, 0.0), (1.2, 0.3, 1.2, 0.9)])
def test_a_fit_through_a_known_curve_is_that_curve(arcs, bend):
    points = arcs(*bend)
    control = curve.fit_points(points, np.linspace(0, 1, len(points)))
    fitted = curve.basis(np.linspace(0, 1, len(points))) @ control
    assert np.abs(fitted - points).max() < 0.06


def test_a_straight_line_is_fitted_exactly_from_few_points():
    ends = np.array([[0.0, 0, 0], [1, 2, 40], [2, 4, 80]])
    control = curve.fit_points(ends, np.array([0.0, 0.5, 1.0]))
    assert curve.basis(np.array([0.25, 0.75])) @ control == pytest.approx(
        np.array([[0.5, 1, 20], [1.5, 3, 60]]), abs=1e-6
    )


def test_smoothness_costs_nothing_where_the_curvature_does_not_change():
    parameter = np.linspace(0, 1, 200)
    parabola = np.column_stack([parameter, parameter**2, 3 - parameter**2])
    control = np.linalg.lstsq(curve.basis(parameter), parabola, rcond=None)[0]
    assert np.abs(curve.JUMPS @ control).max() < 1e-8
