import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.simulated.robot.errors import RobotInputError
from drivers.simulated.robot.robot import static_shape
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings, ideal

THREE_TENDONS = SectionSettings(tendon_angles_deg=(90.0, -30.0, 210.0), backbone_radius_mm=0.25)
REFERENCE = ideal(SimulatedRobotSettings(sections=(THREE_TENDONS, THREE_TENDONS)))
ONE_PERCENT_OF_LENGTH_MM = 0.8
BENCH = SimulatedRobotSettings()
tensions = st.lists(st.floats(0, 6), min_size=8, max_size=8).map(np.array)


@pytest.mark.parametrize(
    ("tension_N", "tip_mm"),
    [
        ((0.5, 0, 0, 0, 0, 0), (0, 25.479, 74.999)),
        ((0, 0, 0, 0.5, 0, 0), (0, 32.729, 70.234)),
        ((0.5, 0, 0, 0, 0.3, 0), (17.727, 15.218, 75.525)),
        ((1, 0.1, 0.1, 0.1, 0.6, 0.1), (28.355, 27.065, 66.485)),
        ((2, 0, 0, 0, 1, 0), (44.327, 43.785, 27.537)),
    ],
)
def test_agrees_with_subsegment_cosserat_poses(tension_N, tip_mm):
    """Tips of an independent subsegment Cosserat model of the same robot."""
    tip = static_shape(REFERENCE, tension_N).centreline_mm[-1]
    assert np.linalg.norm(tip - tip_mm) < ONE_PERCENT_OF_LENGTH_MM


def test_without_tension_an_ideal_robot_is_straight():
    shape = static_shape(ideal(BENCH), np.zeros(8), insertion_mm=12.0)
    straight = np.column_stack([np.zeros((81, 2)), 12.0 + np.arange(81)])
    np.testing.assert_allclose(shape.centreline_mm, straight, atol=1e-9)
    np.testing.assert_allclose(shape.tangents, np.tile([0, 0, 1.0], (81, 1)), atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(tensions)
def test_length_never_changes(tension_N):
    shape = static_shape(BENCH, tension_N)
    chords = np.linalg.norm(np.diff(shape.centreline_mm, axis=0), axis=1)
    assert (chords <= 1.0 + 1e-9).all()
    np.testing.assert_allclose(chords.sum(), 80.0, atol=0.05)
    np.testing.assert_allclose(np.linalg.norm(shape.tangents, axis=1), 1.0, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(tensions)
def test_turning_the_tensions_by_a_quarter_turns_the_shape(tension_N):
    """Tendons stand at 0, 180, 90, 270 and 45, 225, 135, 315 degrees."""
    turned_N = np.empty(8)
    turned_N[[2, 3, 1, 0, 6, 7, 5, 4]] = tension_N
    shape = static_shape(ideal(BENCH), tension_N).centreline_mm
    turned = static_shape(ideal(BENCH), turned_N).centreline_mm
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(turned, shape @ quarter.T, atol=0.01)


def test_gravity_lowers_a_bent_tip():
    pull = [6.0, 0, 0, 0, 0, 0, 0, 0]
    light = ideal(BENCH)
    heavy = msgspec.structs.replace(light, gravity_m_s2=9.81)
    assert (
        static_shape(heavy, pull).centreline_mm[-1, 2] < static_shape(light, pull).centreline_mm[-1, 2] - 1.0
    )


def test_precurvature_leans_the_way_its_sign_says():
    section = msgspec.structs.replace(
        BENCH.sections[0], stiffness_variation=0.0, precurvature_per_mm=(0.01, 0.005)
    )
    tip = static_shape(msgspec.structs.replace(ideal(BENCH), sections=(section,)), np.zeros(4)).centreline_mm[
        -1
    ]
    assert tip[0] > tip[1] > 1.0


def test_stiffness_variation_bends_the_soft_end_more():
    section = msgspec.structs.replace(
        BENCH.sections[0], stiffness_variation=0.4, precurvature_per_mm=(0.0, 0.0)
    )
    robot = msgspec.structs.replace(ideal(BENCH), sections=(section,))
    tangents = static_shape(robot, [4.0, 0, 0, 0]).tangents
    base, tip = (np.arccos(tangents[i] @ tangents[j]) for i, j in ((0, 20), (60, 80)))
    assert tip > 1.5 * base


@pytest.mark.parametrize("sections", [1, 3])
def test_any_number_of_sections(sections):
    robot = msgspec.structs.replace(ideal(BENCH), sections=(BENCH.sections[0],) * sections)
    shape = static_shape(robot, np.full(4 * sections, 1.0))
    chords = np.linalg.norm(np.diff(shape.centreline_mm, axis=0), axis=1)
    np.testing.assert_allclose(chords.sum(), 40.0 * sections, atol=0.01)


@pytest.mark.parametrize("tension_N", [[1.0], [-1.0] + [0.0] * 7, [np.nan] + [0.0] * 7])
def test_unusable_tensions_are_refused_by_name(tension_N):
    with pytest.raises(RobotInputError, match="tension_N is"):
        static_shape(BENCH, tension_N)
