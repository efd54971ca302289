"""What may happen to a robot while it runs: pushes, slipping tendons, another payload; and tendons with a servo each."""

import msgspec
import numpy as np
import pytest

from drivers.simulated.robot.errors import RobotBuildError, RobotInputError
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings, ideal

BENCH = SimulatedRobotSettings()
ZERO = np.zeros(4)
FREE = {"tendon_compliance_mm_per_N": 1e6, "pretension_N": 0.0}
"""Tendons this soft leave the rod to itself."""


def settled(robot, servo_mm, steps=60):
    for _ in range(steps):
        state = robot.step(servo_mm, 0.0, 0.05)
    return state


def tip(state):
    return state.shape.centreline_mm[-1]


def test_a_push_bends_a_free_rod_as_a_cantilever():
    robot = SimulatedRobot(msgspec.structs.replace(ideal(BENCH), **FREE))
    robot.push([0.0, 0.01, 0.0])
    bending_N_mm2 = 60e3 * np.pi / 4 * 0.4**4
    assert tip(settled(robot, ZERO))[1] == pytest.approx(0.01 * 80**3 / (3 * bending_N_mm2), rel=0.01)
    robot.push(np.zeros(3))
    np.testing.assert_allclose(tip(settled(robot, ZERO)), [0, 0, 80], atol=1e-3)


def test_a_push_downwards_is_a_payload():
    weight_N = 0.02 * BENCH.gravity_m_s2
    heavier = msgspec.structs.replace(BENCH, tip_payload_g=BENCH.tip_payload_g + 20)
    pushed, loaded = SimulatedRobot(BENCH), SimulatedRobot(BENCH)
    pushed.push([0, 0, -weight_N])
    loaded.rebuild(heavier)
    bent_mm = [3.0, -2.0, 1.0, 0.0]
    expected = tip(settled(SimulatedRobot(heavier), bent_mm))
    np.testing.assert_allclose(tip(settled(pushed, bent_mm)), tip(settled(loaded, bent_mm)), atol=1e-9)
    np.testing.assert_allclose(tip(settled(loaded, bent_mm)), expected, atol=0.05)
    assert np.linalg.norm(expected - tip(settled(SimulatedRobot(BENCH), bent_mm))) > 0.1


def test_a_push_in_the_middle_moves_the_middle_more_than_the_tip_would_be():
    robot, other = SimulatedRobot(BENCH), SimulatedRobot(BENCH)
    before = settled(robot, ZERO).shape.centreline_mm[40]
    robot.push([0.5, 0, 0], disk=9)
    other.push([0.5, 0, 0])
    moved = [settled(one, ZERO).shape.centreline_mm[40, 0] - before[0] for one in (robot, other)]
    assert moved[0] > 0.1
    assert moved[0] != pytest.approx(moved[1], rel=0.1)


def test_what_slips_is_what_the_servo_paid_out():
    frictionless = msgspec.structs.replace(BENCH, friction_coefficient=0.0, backlash_mm=0.0)
    slipped, turned = SimulatedRobot(frictionless), SimulatedRobot(frictionless)
    slipped.slip([0.5, -0.5, 0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(
        tip(settled(slipped, [2.0, 0, 0, 0])), tip(settled(turned, [1.5, 0, 0, 0])), atol=1e-6
    )


def test_a_snapped_tendon_is_slack_and_its_partner_pulls_the_robot_over():
    robot = SimulatedRobot(BENCH)
    before = tip(settled(robot, ZERO))
    robot.slip([100.0] + [0.0] * 7)
    state = settled(robot, ZERO)
    assert state.tendon_tension_N[0] == 0.0
    assert tip(state)[0] < before[0] - 2.0


def test_a_stiffer_section_yields_less_to_a_push_and_is_taken_up_without_a_jump():
    robot = SimulatedRobot(BENCH)
    straight = tip(settled(robot, ZERO))
    robot.push([0.3, 0, 0])
    before = tip(settled(robot, ZERO))
    proximal, distal = BENCH.sections
    stiffer = msgspec.structs.replace(distal, youngs_modulus_GPa=180.0)
    robot.rebuild(msgspec.structs.replace(BENCH, sections=(proximal, stiffer)))
    at_once, later = tip(robot.step(ZERO, 0.0, 0.005)), tip(settled(robot, ZERO))
    assert np.linalg.norm(later - straight) < np.linalg.norm(before - straight) - 0.1
    assert np.linalg.norm(at_once - before) < np.linalg.norm(later - before) / 2


def test_pushes_and_slips_outlast_a_rebuild():
    robot, other = SimulatedRobot(BENCH), SimulatedRobot(BENCH)
    for one in (robot, other):
        one.push([0.1, 0, 0])
        one.slip([0.3, -0.3, 0, 0, 0, 0, 0, 0])
    robot.rebuild(BENCH)
    np.testing.assert_allclose(tip(settled(robot, ZERO)), tip(settled(other, ZERO)), atol=1e-9)


def test_a_running_robot_keeps_its_sections_and_tendons():
    robot = SimulatedRobot(BENCH)
    proximal, distal = BENCH.sections
    for section in (
        msgspec.structs.replace(distal, length_mm=41.0),
        msgspec.structs.replace(distal, tendon_angles_deg=(0.0, 180.0)),
        msgspec.structs.replace(distal, disk_spacing_mm=8.0),
    ):
        with pytest.raises(RobotBuildError, match="keeps its sections"):
            robot.rebuild(msgspec.structs.replace(BENCH, sections=(proximal, section)))


@pytest.mark.parametrize(
    ("cause", "named"),
    [
        (lambda robot: robot.push([np.nan, 0, 0]), "force_N is"),
        (lambda robot: robot.push([0, 0, 1], disk=20), "disk is 20"),
        (lambda robot: robot.slip([0.5]), "tendon_mm is"),
    ],
)
def test_what_cannot_happen_is_refused_by_name(cause, named):
    with pytest.raises(RobotInputError, match=named):
        cause(SimulatedRobot(BENCH))


@pytest.mark.parametrize("sections", [1, 4])
def test_single_tendons_each_have_a_servo_and_bend_towards_themselves(sections):
    angles_deg = (90.0, 210.0, 330.0)
    section = SectionSettings(
        tendon_angles_deg=angles_deg, stiffness_variation=0.0, precurvature_per_mm=(0.0, 0.0)
    )
    settings = msgspec.structs.replace(ideal(BENCH), sections=(section,) * sections, tendons_per_servo=1)
    assert SimulatedRobot(settings).servos == 3 * sections
    for servo, angle_deg in enumerate(angles_deg):
        pull_mm = np.zeros(3 * sections)
        pull_mm[-3:] = -0.5
        pull_mm[-3 + servo] = 1.0
        x, y, _ = tip(settled(SimulatedRobot(settings), pull_mm, steps=20))
        assert np.degrees(np.arctan2(y, x)) % 360 == pytest.approx(angle_deg, abs=1.0)


def test_a_common_pull_of_single_tendons_is_pretension():
    section = SectionSettings(
        tendon_angles_deg=(90.0, 210.0, 330.0), stiffness_variation=0.0, precurvature_per_mm=(0.0, 0.0)
    )
    settings = msgspec.structs.replace(
        ideal(BENCH),
        sections=(section,),
        tendons_per_servo=1,
        pretension_N=0.0,
        tendon_compliance_mm_per_N=0.3,
    )
    state = settled(SimulatedRobot(settings), np.full(3, 0.6))
    np.testing.assert_allclose(tip(state)[:2], 0.0, atol=1e-3)
    np.testing.assert_allclose(state.tendon_tension_N, 2.0, rtol=0.05)
    np.testing.assert_allclose(state.servo_load_N, state.tendon_tension_N)


def test_three_pairs_share_three_servos():
    section = SectionSettings(tendon_angles_deg=(0.0, 180.0, 60.0, 240.0, 120.0, 300.0))
    assert SimulatedRobot(msgspec.structs.replace(BENCH, sections=(section,))).servos == 3
