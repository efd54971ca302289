"""The constant-curvature model against integration along the backbone, numeric derivatives and cases done by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from controller.errors import ControllerSetupError
from controller.kinematics import Kinematics

LENGTHS = {1: [50.0], 2: [40.0, 40.0], 3: [30.0, 40.0, 20.0]}
ARCS = np.array([0.0, 7.0, 29.9, 30.1, 45.0, 71.0, 90.0])
RADII = [4.0, 3.5, 3.0]
sections = st.integers(1, 3)


ANGLES = {
    "two pairs": ([0, 90], [45, 135], [20, 130]),
    "three pairs": ([0, 60, 120], [20, 80, 140], [40, 100, 160]),
    "three tendons": ([90, -30, 210], [30, 150, 270], [0, 120, 240]),
    "mixed": ([0, 90], [90, -30, 210], [10, 70, 130, 200]),
}
robots = st.builds(
    lambda count, angles, coupling, stage: model(count, angles, coupling=coupling, stage=stage),
    sections,
    st.sampled_from(sorted(ANGLES)),
    st.sampled_from([0.0, 0.5, 1.0]),
    st.booleans(),
)


def model(count, angles="two pairs", **how):
    return Kinematics(
        LENGTHS[count], [np.radians(own) for own in ANGLES[angles][:count]], RADII[:count], **how
    )


def commands(kinematics, size=6.0):
    """Commands that bend no section beyond some 3 rad."""
    return arrays(
        np.float64, kinematics.command_of_coordinates.shape[1], elements=st.floats(-size, size)
    ).map(lambda coordinates: kinematics.command_of_coordinates @ coordinates)


def bends(kinematics, command_mm):
    """(2 S,) rad, from Clarke coordinates: a section's own, less what its tendons lose by crossing the sections before."""
    coordinates = (kinematics.coordinates_of_command @ command_mm)[: 2 * len(kinematics.length_mm)].reshape(
        -1, 2
    )
    found = []
    for coordinate, radius in zip(coordinates, RADII, strict=False):
        found.append(coordinate / radius - kinematics.coupling * sum(found, np.zeros(2)))
    return np.concatenate(found)


def integrated(kinematics, command_mm, arc_mm, steps=900):
    """The point at `arc_mm` by walking along the backbone in small straight pieces, frames turned piece by piece."""
    bend = bends(kinematics, command_mm)
    point, frame = np.array([0.0, 0.0, command_mm[-1] if kinematics.stage else 0.0]), np.eye(3)
    piece_mm = arc_mm / steps
    ends = np.cumsum(kinematics.length_mm)
    for step in range(steps):
        section = min(np.searchsorted(ends, (step + 0.5) * piece_mm), len(ends) - 1)
        x, y = bend[2 * section : 2 * section + 2] / kinematics.length_mm[section] * piece_mm
        angle = np.hypot(x, y)
        axis = np.array([-y, x, 0.0]) / max(angle, 1e-300)
        skew = np.cross(np.eye(3), axis)
        half = np.eye(3) + np.sin(angle / 2) * skew + (1 - np.cos(angle / 2)) * skew @ skew
        frame = frame @ half
        point = point + piece_mm * frame[:, 2]
        frame = frame @ half
    return point


@settings(max_examples=60)
@given(st.data(), robots)
def test_jacobian_is_the_derivative(data, kinematics):
    command = data.draw(commands(kinematics))
    nodes, jacobian = kinematics.nodes_and_jacobian(command, ARCS)
    small = 1e-6
    for axis, unit in enumerate(np.eye(kinematics.axes)):
        ahead, behind = (kinematics.nodes_mm(command + sign * small * unit, ARCS) for sign in (1, -1))
        np.testing.assert_allclose(jacobian[..., axis], (ahead - behind) / (2 * small), atol=1e-6)
    np.testing.assert_array_equal(nodes, kinematics.nodes_mm(command, ARCS))


@settings(max_examples=6, deadline=None)
@given(st.data(), robots)
def test_points_agree_with_integration(data, kinematics):
    command = data.draw(commands(kinematics))
    arc = kinematics.length_mm.sum()
    reached = kinematics.nodes_mm(command, np.array([arc * 0.6, arc]))
    # a piece of the walk may lie across the border of two sections
    np.testing.assert_allclose(reached[0], integrated(kinematics, command, arc * 0.6), atol=5e-3)
    np.testing.assert_allclose(reached[1], integrated(kinematics, command, arc), atol=5e-3)


@given(st.data(), robots, st.sampled_from([0.0, 1e-300, 1e-160, 1e-9, 1e-4]))
def test_smooth_through_the_straight_pose(data, kinematics, size):
    direction = data.draw(commands(kinematics, 1.0))
    straight, flat = kinematics.nodes_and_jacobian(np.zeros(kinematics.axes), ARCS)
    near, near_flat = kinematics.nodes_and_jacobian(size * direction, ARCS)
    np.testing.assert_allclose(straight, np.outer(ARCS, [0, 0, 1]), atol=1e-12)
    np.testing.assert_allclose(near, straight + flat @ (size * direction), atol=1e3 * size**2 + 1e-12)
    np.testing.assert_allclose(near_flat, flat, atol=1e3 * size + 1e-12)


def test_many_commands_at_once_are_the_same_as_one_by_one():
    kinematics = model(3)
    many = np.random.default_rng(4).uniform(-5, 5, (2, 5, kinematics.axes))
    nodes, jacobian = kinematics.nodes_and_jacobian(many, ARCS)
    for index in np.ndindex(2, 5):
        one, one_jacobian = kinematics.nodes_and_jacobian(many[index], ARCS)
        np.testing.assert_allclose(nodes[index], one, atol=1e-12)
        np.testing.assert_allclose(jacobian[index], one_jacobian, atol=1e-12)


def test_quarter_circle_by_hand():
    kinematics = Kinematics([40.0], np.radians([[0, 90]]), [4.0])
    pulled = np.array([4.0 * np.pi / 2, 0.0, 3.0])
    radius = 40.0 / (np.pi / 2)
    np.testing.assert_allclose(
        kinematics.nodes_mm(pulled, np.array([40.0])), [[radius, 0.0, radius + 3.0]], atol=1e-12
    )


def test_distal_tendons_shorten_by_the_bend_of_the_sections_they_cross():
    kinematics = Kinematics([40.0, 40.0], np.radians([[0, 90], [0, 90]]), [4.0, 3.0])
    only_proximal = np.array([2.0, 0.0, 1.5, 0.0])
    tip, middle = kinematics.nodes_mm(np.append(only_proximal, 0.0), np.array([80.0, 40.0]))
    # the distal section stays straight: the tip lies ahead of the middle along the tangent there
    np.testing.assert_allclose(tip - middle, 40 * np.array([np.sin(0.5), 0, np.cos(0.5)]), atol=1e-12)


@given(st.data(), robots)
def test_clarke_coordinates_and_commands_lead_to_one_another(data, kinematics):
    coordinates = data.draw(
        arrays(np.float64, kinematics.command_of_coordinates.shape[1], elements=st.floats(-5, 5))
    )
    command = kinematics.command_of_coordinates @ coordinates
    np.testing.assert_allclose(kinematics.coordinates_of_command @ command, coordinates, atol=1e-12)


def test_clarke_transform_of_evenly_spaced_tendons_is_the_textbook_one():
    angle = np.radians([0, 90, 180, 270])
    kinematics = Kinematics([40.0], [angle], [4.0], stage=False)
    textbook = 2 / 4 * np.stack([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(kinematics.coordinates_of_command, textbook, atol=1e-15)


@given(st.data(), robots)
def test_tightening_bends_nothing(data, kinematics):
    amount = data.draw(arrays(np.float64, kinematics.axes, elements=st.floats(-3, 3)))
    command = data.draw(commands(kinematics))
    if not len(kinematics.tightening):
        return
    tighter = command + kinematics.tightening @ amount
    np.testing.assert_allclose(
        kinematics.nodes_mm(tighter, ARCS), kinematics.nodes_mm(command, ARCS), atol=1e-9
    )


def test_three_tendons_are_tightened_by_pulling_all_alike():
    kinematics = model(1, "three tendons", stage=False)
    np.testing.assert_allclose(kinematics.tightening, np.full((3, 3), 1 / 3), atol=1e-12)


@pytest.mark.parametrize(
    ("lengths", "angles", "message"),
    [
        ([40.0], [[30]], "section 1: tendons at .30.* degrees must not all pull the same way"),
        ([40.0], [[0, 90], [45, 135]], "2 sections, the robot has 1"),
        ([40.0, 40.0], [[0, 90], [45, 225]], "must not all pull the same way"),
    ],
)
def test_tendons_that_do_not_fit_are_refused(lengths, angles, message):
    with pytest.raises(ControllerSetupError, match=message):
        Kinematics(lengths, np.radians(angles), [4.0] * len(angles))
