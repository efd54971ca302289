"""The motor behind the registers: it follows, saturates, gives way and warms up as the datasheet's does."""

import itertools
import math

import pytest

from drivers.simulated.servos.motor import COASTING, Drive, Motor
from drivers.simulated.servos.settings import MotorSettings

STIFFNESS_V_PER_RAD = 55.0


@pytest.fixture
def motor():
    return Motor(MotorSettings())


def run(motor, drive, seconds, load_Nm=0.0, dt_s=0.005):
    """Step and return the speeds on the way."""
    speeds = []
    for _ in range(round(seconds / dt_s)):
        motor.step(dt_s, drive, load_Nm)
        speeds.append(motor.velocity_rad_s)
    return speeds


def hold(goal_rad, **limits):
    return Drive(goal_rad=goal_rad, stiffness_V_per_rad=STIFFNESS_V_PER_RAD, **limits)


@pytest.mark.parametrize("goal_rad", [0.5, -3.0, 20.0])
def test_it_reaches_a_goal_and_rests(motor, goal_rad):
    run(motor, hold(goal_rad), 8)
    assert motor.position_rad == pytest.approx(goal_rad, abs=0.01)
    assert motor.velocity_rad_s == 0


def test_it_is_no_faster_than_without_load(motor):
    settings = MotorSettings()
    assert max(run(motor, hold(100.0), 2)) == pytest.approx(settings.no_load_speed_rad_s, rel=0.05)


def test_its_stall_current_and_torque_are_the_datasheets(motor):
    run(motor, hold(0.0), 3, load_Nm=4.0)
    assert motor.velocity_rad_s == 0
    assert motor.current_A == pytest.approx(2.3 * 4.0 / 4.1, rel=0.03)


def test_a_load_pushes_it_aside_in_proportion(motor):
    run(motor, hold(0.0), 2, load_Nm=1.0)
    softness = motor.position_rad
    run(motor, hold(0.0), 2, load_Nm=2.0)
    assert softness < 0
    assert motor.position_rad == pytest.approx(2 * softness, rel=0.15)


def test_a_current_bound_lets_it_slip(motor):
    run(motor, hold(0.0, current_limit_A=0.5), 2, load_Nm=2.0)
    assert motor.position_rad < -1


def test_a_profile_bounds_speed_and_acceleration(motor):
    drive = hold(4.0, profile_velocity_rad_s=2.0, profile_acceleration_rad_s2=4.0)
    profile = []
    for _ in range(1000):
        motor.step(0.005, drive, 0.0)
        profile.append(motor.profile_rad_s)
    assert max(profile) == pytest.approx(2.0, rel=1e-6)
    assert max(abs(b - a) for a, b in itertools.pairwise(profile)) <= 4.0 * 0.005 * (1 + 1e-6)
    assert motor.position_rad == pytest.approx(4.0, abs=0.01)


def test_a_new_goal_on_the_way_keeps_the_speed_smooth(motor):
    limits = {"profile_velocity_rad_s": 2.0, "profile_acceleration_rad_s2": 8.0}
    run(motor, hold(4.0, **limits), 0.5)
    before = motor.profile_rad_s
    motor.step(0.005, hold(-4.0, **limits), 0.0)
    assert abs(motor.profile_rad_s - before) <= 8.0 * 0.005 * (1 + 1e-6)
    run(motor, hold(-4.0, **limits), 8)
    assert motor.position_rad == pytest.approx(-4.0, abs=0.01)


def test_velocity_and_current_goals(motor):
    run(motor, Drive(goal_rad_s=2.0), 1)
    assert motor.velocity_rad_s == pytest.approx(2.0, rel=0.02)
    run(motor, Drive(goal_A=0.0), 3)
    assert motor.velocity_rad_s == 0
    run(motor, Drive(goal_A=-0.5), 0.01)
    assert motor.current_A == pytest.approx(-0.5)


def test_without_torque_only_friction_holds(motor):
    run(motor, COASTING, 1, load_Nm=0.07)
    assert motor.position_rad == 0
    run(motor, COASTING, 1, load_Nm=0.5)
    assert motor.position_rad < -1
    assert motor.current_A == 0


def test_current_warms_it_and_rest_cools_it(motor):
    run(motor, hold(0.0), 20, load_Nm=3.0, dt_s=0.02)
    hot = motor.temperature_C
    assert 30 < hot < 80
    run(motor, COASTING, 20, dt_s=0.02)
    assert motor.temperature_C < hot


def test_the_step_length_hardly_matters():
    angles = []
    for dt_s in (0.001, 0.002, 0.005):
        motor = Motor(MotorSettings())
        run(motor, hold(1.0, profile_velocity_rad_s=3.0, profile_acceleration_rad_s2=50.0), 0.3, 0.3, dt_s)
        angles.append(motor.position_rad)
    assert max(angles) - min(angles) < 1e-6
    assert not math.isclose(angles[0], 0)
