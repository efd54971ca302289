"""The robot frame from midlines of the robot: exact arcs in a known frame."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.base import apart_from
from calibration.base_robot import Pose, Pull, base_from_robot
from calibration.errors import BasePosesError

LENGTH_MM = 80.0
AT_REST = (0.12, -0.2)
"""Bends in rad towards X and Y of a robot that is not straight when nothing pulls."""
ANGLES = (0.0, np.pi / 2, np.pi / 4, 3 * np.pi / 4)


def frame(turn=(1.5, 0.3, -0.2), place=(3.0, 25.0, 199.0)):
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(np.array(turn, float))[0]
    matrix[:3, 3] = place
    return matrix


def arc(bend, count=81):
    """A circular arc (n, 3) from the origin along +Z that bends by (2,) rad."""
    angle = max(float(np.linalg.norm(bend)), 1e-9)
    turned = np.linspace(0, angle, count)
    aside, along = LENGTH_MM * (1 - np.cos(turned)) / angle, LENGTH_MM * np.sin(turned) / angle
    return np.column_stack([aside[:, None] * np.array(bend) / angle, along])


def pose(true, bend, insertion_mm=0.0, noise_mm=0.0, random=None, insertion_said_mm=None):
    points = arc(bend) + np.array([0, 0, insertion_mm])
    if random is not None:
        points = points + random.normal(0, noise_mm, (1, 3))
    said_mm = insertion_mm if insertion_said_mm is None else insertion_said_mm
    return Pose(points @ true[:3, :3].T + true[:3, 3], said_mm)


def towards(angle, size, rest=AT_REST):
    return np.array(rest) + size * np.array([np.cos(angle), np.sin(angle)])


def pulls(true, angles=ANGLES, said=ANGLES, size=0.5, both=True, **more):
    return [
        Pull(
            f"tendon {number}",
            told,
            (pose(true, towards(angle, -size if both else 0.0), **more),),
            (pose(true, towards(angle, size), **more),),
        )
        for number, (angle, told) in enumerate(zip(angles, said, strict=True))
    ]


def travel(true, places_mm=(0.0, 5.0, 10.0, 15.0), scale=1.0, **more):
    return [
        pose(true, AT_REST, place_mm, insertion_said_mm=place_mm / scale, **more) for place_mm in places_mm
    ]


@settings(max_examples=25, deadline=None)
@given(
    st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3)),
    st.booleans(),
)
def test_a_bent_robot_at_rest_still_gives_its_exact_frame(turn, both):
    true = frame(turn)
    base = base_from_robot(pulls(true, both=both), travel(true), {"left": 0.1})
    apart = apart_from(true, base.matrix)
    assert apart.origin_mm < 0.01
    assert apart.axis_rad < 1e-6
    assert abs(apart.roll_rad) < 0.01
    assert base.residual_px == {"left": 0.1}
    assert base.robot.travel_mm == pytest.approx(15.0)
    assert base.robot.stage_scale == pytest.approx(1.0)


def test_noise_stays_within_what_is_said_of_it():
    random, true = np.random.default_rng(5), frame()
    far = []
    for _ in range(40):
        base = base_from_robot(
            pulls(true, noise_mm=0.05, random=random), travel(true, noise_mm=0.05, random=random), {}
        )
        apart = apart_from(true, base.matrix)
        far.append(
            [
                apart.origin_mm / base.origin_sigma_mm,
                apart.axis_rad / base.axis_sigma_rad,
                apart.roll_rad / base.roll_sigma_rad,
            ]
        )
    rms = np.sqrt(np.mean(np.square(far), axis=0))
    assert (rms < 1.3).all()
    assert rms[1] > 0.3


def test_without_a_stage_z_is_how_the_robot_leaves_its_holder():
    true = frame()
    base = base_from_robot(pulls(true), [], {})
    with_stage = base_from_robot(pulls(true), travel(true), {})
    apart = apart_from(true, base.matrix)
    assert apart.axis_rad < np.radians(0.2)
    assert base.axis_sigma_rad > 3 * with_stage.axis_sigma_rad
    assert base.robot.travel_mm == 0.0


def test_a_robot_that_leans_in_its_holder_does_not_tilt_the_axis_and_is_told_of():
    true, leaning = frame(), frame() @ frame((0.05, 0, 0), (0, 0, 0))
    up = true[:3, 2]
    shifted = [Pose(pose(leaning, AT_REST).points_mm + height * up, height) for height in (0.0, 6.0, 12.0)]
    base = base_from_robot(pulls(leaning), shifted, {})
    assert apart_from(true, base.matrix).axis_rad < 1e-6
    assert base.robot.lean_deg == pytest.approx(np.degrees(0.05), abs=0.2)


def test_a_stage_that_was_hardly_seen_is_refused():
    true = frame()
    with pytest.raises(BasePosesError, match=r"over 3\.0 mm of travel"):
        base_from_robot(pulls(true), travel(true, (0.0, 1.5, 3.0)), {})


def test_a_stage_whose_travel_is_another_than_the_cameras_see_is_refused():
    true = frame()
    with pytest.raises(BasePosesError, match=r"went 15\.0 mm, and the cameras saw 16\.5 mm"):
        base_from_robot(pulls(true), travel(true, (0.0, 5.5, 11.0, 16.5), scale=1.1), {})


def test_a_stage_with_the_wrong_sign_is_named():
    true = frame()
    counted_down = [
        Pose(pose(true, AT_REST, up_mm).points_mm, insertion_mm=20.0 - up_mm) for up_mm in (0.0, 5.0, 10.0)
    ]
    with pytest.raises(BasePosesError, match=r"servos\.stage\.mm_per_rad has the wrong sign"):
        base_from_robot(pulls(true), counted_down, {})


def signed(*wrong):
    """What tendons' angles are said to be where the signs of these are wrong."""
    return [angle + np.pi * (number in wrong) for number, angle in enumerate(ANGLES)]


@pytest.mark.parametrize(
    ("wrong", "opposed", "turned"), [((2,), {2}, False), ((0, 1, 3), {2}, True), ((0, 1, 2, 3), set(), True)]
)
def test_wrong_signs_are_told_from_right_ones_by_most_tendons(wrong, opposed, turned):
    true = frame()
    base = base_from_robot(pulls(true, said=signed(*wrong)), travel(true), {})
    assert {number for number, pull in enumerate(base.robot.pulls) if pull.reversed} == opposed
    assert max(abs(pull.off_deg) for pull in base.robot.pulls) < 0.5
    roll_rad = abs(apart_from(true, base.matrix).roll_rad)
    assert roll_rad == pytest.approx(np.pi if turned else 0.0, abs=0.01)


def test_as_many_wrong_signs_as_right_ones_are_refused_with_both_readings():
    true = frame()
    with pytest.raises(BasePosesError, match=r"tendon 0, tendon 3 say .*, tendon 1, tendon 2 the opposite"):
        base_from_robot(pulls(true, said=signed(0, 3)), travel(true), {})


def test_a_tendon_in_another_place_is_named():
    true = frame()
    elsewhere = (0.0, np.pi / 2, np.pi / 4 + np.pi / 3, 3 * np.pi / 4)
    with pytest.raises(BasePosesError, match=r"off by degrees: .*tendon 2 [+-][345]\d"):
        base_from_robot(pulls(true, said=elsewhere), travel(true), {})


def test_slack_tendons_have_no_say_and_two_must_have_one():
    true = frame()
    slack = pulls(true, angles=ANGLES[:2], said=(1.0, 2.0), size=0.01)
    base = base_from_robot([*slack, *pulls(true)[2:]], travel(true), {})
    assert [pull.name for pull in base.robot.pulls] == ["tendon 2", "tendon 3"]
    assert abs(apart_from(true, base.matrix).roll_rad) < 0.01
    with pytest.raises(BasePosesError, match="1 of 3 tendons"):
        base_from_robot([*slack, *pulls(true)[2:3]], travel(true), {})
