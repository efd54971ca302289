"""The drive of a virtual bench does what the driver of a real one does."""

import numpy as np
import pytest

from drivers.actuators import ActuatorError, CommandRefusedError, WatchdogExpiredError
from nodal.virtual.actuators import VirtualActuators
from nodal.virtual.plant import Plant
from nodal.virtual.settings import ServoSettings, VirtualBenchSettings

PERIOD_S = 0.005
ZERO = np.zeros(4)
TICK_MM = 5.0 * 2 * np.pi / 4096


FRICTION_MM = 0.05
"""How far from its goal a servo without integral action may stand."""
BENCH = VirtualBenchSettings()


class Rig:
    """Servos and their drive, with time that goes on."""

    def __init__(self, settings=BENCH):
        self.plant = Plant(settings)
        self.drive = VirtualActuators(
            settings.servos, self.plant.servos, self.plant.nominal_mm_per_rad, self.plant.tendon_axes
        )
        self.now_s = 1.0
        self.drive.pass_time(self.now_s)
        self.drive.open()

    def wait(self, duration_s, goal_mm=None):
        for _ in range(round(duration_s / PERIOD_S)):
            if goal_mm is not None:
                self.drive.read()
                self.drive.write(*goal_mm)
            self.plant.turn(PERIOD_S, self.now_s)
            self.now_s += PERIOD_S
            self.drive.pass_time(self.now_s)


@pytest.fixture
def rig():
    return Rig()


def test_goals_are_reached(rig):
    rig.drive.enable()
    rig.wait(1.0, ([1.0, -2.0, 0.5, 0.0], 7.0))
    state = rig.drive.read()
    assert state.torque
    np.testing.assert_allclose(state.displacement_mm, [1.0, -2.0, 0.5, 0.0], atol=FRICTION_MM)
    assert state.insertion_mm == pytest.approx(7.0, abs=0.05)
    np.testing.assert_allclose(state.position_mm, np.append(state.displacement_mm, state.insertion_mm))


def test_without_torque_nothing_follows(rig):
    rig.wait(0.5, (ZERO + 1.0, 5.0))
    state = rig.drive.read()
    assert not state.torque
    np.testing.assert_allclose(state.position_mm, 0.0, atol=TICK_MM)


def test_speed_and_current_keep_to_the_settings():
    rig = Rig(
        VirtualBenchSettings(servos=ServoSettings(profile_velocity_rad_s=1.0, maximum_current_ma=300.0))
    )
    rig.drive.enable()
    rig.wait(0.3, (ZERO + 5.0, 0.0))
    state = rig.drive.read()
    assert state.displacement_mm_s.max() == pytest.approx(5.0, rel=0.1)
    rig.plant.jammed.add(0)
    rig.wait(0.5, (ZERO + 5.0, 0.0))
    assert rig.drive.read().current_ma[0] == pytest.approx(300.0, rel=0.02)


def test_zero_is_where_it_is_said_to_be(rig):
    rig.drive.enable()
    rig.wait(1.0, (ZERO + 1.0, 3.0))
    rig.drive.set_zero(ZERO, 3.0)
    np.testing.assert_allclose(rig.drive.read().displacement_mm, 0.0, atol=TICK_MM)


def test_a_silent_bus_stops_the_servos_and_disable_makes_them_usable_again(rig):
    rig.drive.enable()
    rig.wait(0.1, (ZERO + 3.0, 0.0))
    moved = rig.plant.servos[0].motor.position_rad
    rig.wait(0.3)
    with pytest.raises(WatchdogExpiredError, match="200 ms"):
        rig.drive.read()
    rig.drive.write(ZERO - 3.0, 0.0)
    rig.wait(0.15)
    assert rig.plant.servos[0].motor.position_rad >= moved
    rig.drive.disable()
    assert not rig.drive.read().torque


def test_a_silent_servo_is_named_and_the_others_are_relaxed_once_the_wait_is_over(rig):
    rig.drive.enable()
    rig.drive.silent.add(2)
    with pytest.raises(ActuatorError, match="servo 3"):
        rig.drive.read()
    with pytest.raises(ActuatorError, match="servo 3"):
        rig.drive.close()
    assert all(servo.torque_enabled for servo in rig.plant.servos)
    rig.wait(0.055)
    assert not rig.drive.pass_time(rig.now_s)
    rig.wait(0.01)
    assert [servo.torque_enabled for servo in rig.plant.servos] == [False, False, True, False, False]
    rig.wait(0.06)
    assert rig.drive.pass_time(rig.now_s)


def test_a_servo_that_restarted_is_noticed(rig):
    rig.drive.enable()
    rig.plant.servos[1].reboot(rig.now_s)
    with pytest.raises(ActuatorError, match="servo 2"):
        rig.drive.read()
    rig.wait(0.3)
    with pytest.raises(ActuatorError, match="restarted"):
        rig.drive.read()
    rig.drive.open()
    assert not rig.drive.read().torque


def test_a_hardware_error_is_reported_and_takes_the_torque(rig):
    rig.drive.enable()
    rig.plant.servos[0].fail(0x20)
    state = rig.drive.read()
    assert state.hardware_error == (0x20, 0, 0, 0, 0)
    assert state.alarm == "servo 1: overload"
    assert not state.torque
    with pytest.raises(ActuatorError, match="hardware error"):
        rig.drive.enable()


@pytest.mark.parametrize("goal_mm", [(np.zeros(3), 0.0), (np.full(4, np.nan), 0.0), (ZERO, np.inf)])
def test_what_is_no_goal_is_refused(rig, goal_mm):
    with pytest.raises(CommandRefusedError, match="refused"):
        rig.drive.write(*goal_mm)


def test_a_robot_without_a_stage_has_no_insertion():
    rig = Rig(VirtualBenchSettings(stage=False))
    state = rig.drive.read()
    assert (len(state.current_ma), state.insertion_mm, len(state.position_mm)) == (4, 0.0, 4)
    rig.drive.write(ZERO, 0.0)
    with pytest.raises(CommandRefusedError, match="no stage"):
        rig.drive.write(ZERO, 1.0)
