"""Servos that restart, by themselves or because they are told to: they are named, used again, and found where they were."""

import msgspec
import numpy as np
import pytest

from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.errors import HardwareError, NoAnswerError, RestartedError

OVERLOAD = 0x20


def test_a_restarting_servo_is_silent_then_told_then_usable(line, drive):
    drive.enable()
    line.servos.servo(21).reboot(line.now_s())
    with pytest.raises(NoAnswerError, match="servo 21"):
        drive.read()
    with pytest.raises(NoAnswerError, match="servo 21"):
        drive.close()
    assert not any(servo.torque_enabled for servo in line.servos.servos)
    line.pause(1.0)
    with pytest.raises(RestartedError, match=r"servo \[21\] restarted"):
        drive.open()
    assert not line.is_open
    drive.open()
    assert not drive.read().torque


def test_a_servo_that_shut_down_is_named_rebooted_and_used_again(line, drive):
    drive.enable()
    line.servos.servo(11).fail(OVERLOAD)
    state = drive.read()
    assert state.hardware_error == (OVERLOAD, 0, 0, 0, 0)
    assert not state.torque
    drive.disable()
    with pytest.raises(HardwareError, match=r"servo 11: overload"):
        drive.enable()
    drive._bus.reboot(11)
    with pytest.raises(RestartedError, match=r"servo \[11\]"):
        drive.read()
    drive.close()
    drive.open()
    drive.enable()
    assert drive.read().hardware_error == (0, 0, 0, 0, 0)


class TestPlaceOfTheStage:
    """Its zero stands in the settings; which turn it is in is known to the servo alone, as long as it has power."""

    TURN_MM = 1.5 * 2 * np.pi

    @pytest.fixture
    def stage(self, line, settings):
        stage = msgspec.structs.replace(settings.stage, min_mm=-5.0, max_mm=45.0, zero_ticks=2048)
        drive = TendonActuators(msgspec.structs.replace(settings, stage=stage), line)
        drive.open()
        line.servos.servo(30).motor.position_rad = 30.0 / 1.5
        line.run(0.01)
        assert drive.read().insertion_mm == pytest.approx(30.0, abs=0.01)
        return drive

    def restart(self, line, moved_mm=0.0):
        servo = line.servos.servo(30)
        servo.motor.position_rad += moved_mm / 1.5
        servo.reboot(line.now_s())
        line.pause(1.0)
        line.run(0.01)

    @pytest.mark.parametrize("moved_mm", [0.0, 4.0, -4.0])
    def test_survives_a_restart_of_its_servo(self, line, stage, moved_mm):
        self.restart(line, moved_mm)
        with pytest.raises(RestartedError):
            stage.read()
        stage.close()
        for _ in range(2):
            stage.open()
            assert stage.read().insertion_mm == pytest.approx(30.0 + moved_mm, abs=0.01)
            stage.close()
        self.restart(line)
        with pytest.raises(RestartedError):
            stage.open()
        stage.open()
        assert stage.read().insertion_mm == pytest.approx(30.0 + moved_mm, abs=0.01)

    def test_is_another_when_nobody_saw_it_before(self, line, settings, stage):
        stage.close()
        self.restart(line)
        again = TendonActuators(stage._settings, line)
        again.open()
        assert again.read().insertion_mm == pytest.approx(30.0 - 3 * self.TURN_MM, abs=0.01)
