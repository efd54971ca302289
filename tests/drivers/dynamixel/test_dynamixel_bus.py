"""The bus against emulated servos and everything that can go wrong between them: each trouble has its own error."""

import os
import pty
import time
import tty

import pytest

from drivers.dynamixel import control_table as table
from drivers.dynamixel.bus import DynamixelBus, Identity
from drivers.dynamixel.errors import (
    CorruptAnswerError,
    HardwareError,
    NoAnswerError,
    PortBusyError,
    PortError,
    PortLostError,
    PortMissingError,
    StatusError,
)
from drivers.dynamixel.port import SerialPort
from drivers.simulated.servos.settings import Faults

IDS = (11, 12, 21, 22, 30)
ALWAYS = frozenset(range(1, 1000))


def positions(bus, servos=IDS):
    return bus.sync_read(servos, table.PRESENT_POSITION)


def test_a_servo_says_what_it_is(bus):
    assert bus.ping(11) == Identity(1020, 48)


def test_what_is_written_is_read_back_with_its_sign(bus):
    bus.write(12, table.GOAL_POSITION, -5000)
    assert bus.read(12, table.GOAL_POSITION) == -5000


def test_all_servos_are_written_and_read_at_once(bus):
    goals = {servo: -100 * servo for servo in IDS}
    bus.sync_write(table.GOAL_POSITION, goals)
    assert bus.sync_read(IDS, table.GOAL_POSITION) == goals


def test_all_servos_are_read_in_one_exchange(bench, settings):
    with DynamixelBus(SerialPort(settings.port), answer_timeout_s=1.0, retries=0) as bus:
        assert positions(bus) == dict.fromkeys(IDS, 2048)


def test_a_value_that_looks_like_a_header_comes_through(bus):
    bus.write_bytes(11, 224, b"\xff\xff\xfd\x00\xff\xff\xfd")
    assert bus.read_bytes(11, 224, 7) == b"\xff\xff\xfd\x00\xff\xff\xfd"
    assert bus.sync_read_bytes([11, 12], 224, 7)[11] == b"\xff\xff\xfd\x00\xff\xff\xfd"


def test_a_missing_port_is_named(tmp_path):
    with pytest.raises(PortMissingError, match="no-adapter"):
        DynamixelBus(SerialPort(str(tmp_path / "no-adapter"))).open()


def test_a_second_opener_is_told_that_the_port_is_busy(bus):
    second = DynamixelBus(SerialPort(bus.port))
    with pytest.raises(PortBusyError):
        second.open()
    bus.close()
    with second:
        assert second.ping(11).model_number == 1020


def test_something_that_is_no_serial_port_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(PortError, match="cannot be used"):
        DynamixelBus(SerialPort(str(tmp_path / "file"))).open()


def test_a_port_that_is_not_open_says_so(bench, settings):
    with pytest.raises(PortLostError, match="not open"):
        DynamixelBus(SerialPort(settings.port)).ping(11)


def test_nobody_at_the_other_end_is_an_error_in_bounded_time_without_spinning():
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    with DynamixelBus(SerialPort(os.ttyname(theirs)), answer_timeout_s=0.05, retries=2) as bus:
        wall_s, cpu_s = time.monotonic(), time.process_time()
        with pytest.raises(NoAnswerError, match=r"servo 1 within \d+ ms") as caught:
            bus.read(1, table.PRESENT_POSITION)
        wall_s, cpu_s = time.monotonic() - wall_s, time.process_time() - cpu_s
    os.close(ours)
    os.close(theirs)
    assert caught.value.silent == (1,)
    assert cpu_s < wall_s / 2


def test_a_silent_servo_is_named_and_the_others_are_kept(bench, bus):
    bench.set_faults(Faults(silent=frozenset({12, 30})))
    with pytest.raises(NoAnswerError) as caught:
        positions(bus)
    assert caught.value.silent == (12, 30)
    assert set(caught.value.answers) == {11, 21, 22}
    bench.set_faults(Faults())
    assert set(positions(bus)) == set(IDS)


@pytest.mark.parametrize("fault", ["drop", "corrupt", "truncate"])
@pytest.mark.parametrize("nth", [1, 3, 5])
def test_one_spoilt_answer_is_asked_for_again(bench, bus, fault, nth):
    bench.set_faults(Faults(**{fault: frozenset({nth})}))
    assert positions(bus) == dict.fromkeys(IDS, 2048)
    bench.set_faults(Faults(**{fault: frozenset({1})}))
    assert bus.read(11, table.PRESENT_POSITION) == 2048


def test_answers_that_never_come_are_never_zero(bench, bus):
    bench.set_faults(Faults(drop=ALWAYS))
    with pytest.raises(NoAnswerError):
        bus.read(11, table.PRESENT_POSITION)
    with pytest.raises(NoAnswerError) as caught:
        positions(bus)
    assert caught.value.silent == IDS


@pytest.mark.parametrize("fault", ["corrupt", "truncate"])
def test_answers_that_are_always_spoilt_are_reported_as_corrupt(bench, bus, fault):
    bench.set_faults(Faults(**{fault: ALWAYS}))
    with pytest.raises(CorruptAnswerError, match="ff ff fd 00 0b") as caught:
        bus.read(11, table.PRESENT_POSITION)
    assert caught.value.rubbish
    with pytest.raises(CorruptAnswerError):
        positions(bus)


def test_a_late_answer_is_not_taken_for_the_answer_to_another_question(bench, settings):
    bench.set_faults(Faults(delay=frozenset({1}), delay_s=0.3))
    with DynamixelBus(SerialPort(settings.port), answer_timeout_s=0.2, retries=0) as bus:
        with pytest.raises(NoAnswerError):
            bus.read(11, table.PRESENT_TEMPERATURE)
        bench.set_faults(Faults(drop=frozenset({1})))
        with pytest.raises(NoAnswerError):
            bus.read(11, table.OPERATING_MODE)
        assert bus.read(11, table.OPERATING_MODE) == 5


def test_a_late_answer_is_welcome_to_its_own_question_but_another_is_still_to_come(bench, settings):
    bench.set_faults(Faults(delay=frozenset({1, 2}), delay_s=0.3))
    with DynamixelBus(SerialPort(settings.port), answer_timeout_s=0.2, retries=1) as bus:
        assert bus.read(11, table.PRESENT_TEMPERATURE) == 28
        bench.set_faults(Faults(drop=frozenset({1, 2})))
        time.sleep(0.05)  # the second late answer would come just inside the next question's time
        with pytest.raises(NoAnswerError):
            bus.read(11, table.OPERATING_MODE)


@pytest.mark.parametrize(
    ("register", "value", "meaning"),
    [
        (table.PROFILE_VELOCITY, 40_000, "range"),
        (table.GOAL_CURRENT, 1194, "limit"),
        (table.PRESENT_POSITION, 0, "read-only"),
    ],
)
def test_a_refusal_says_why_and_is_not_repeated(bench, bus, register, value, meaning):
    with pytest.raises(StatusError, match=f"servo 11 refused to set {register.name} to {value}: .*{meaning}"):
        bus.write(11, register, value)


def test_eeprom_is_locked_while_torque_is_on(bus):
    bus.write(11, table.TORQUE_ENABLE, 1)
    with pytest.raises(StatusError, match="EEPROM while torque is on"):
        bus.write(11, table.RETURN_DELAY_TIME, 0)


def test_a_hardware_error_raises_the_alert_and_is_named(bench, bus):
    bench.fail(21, 0x20)
    positions(bus)
    assert bus.alerts == {21}
    with pytest.raises(HardwareError, match="servo 21: overload"):
        bus.check_hardware(IDS)


def test_a_port_that_goes_away_is_closed_and_can_be_opened_again(make_bench, settings):
    bench = make_bench()
    bus = DynamixelBus(SerialPort(settings.port), answer_timeout_s=0.05)
    bus.open()
    bench.close()
    with pytest.raises(PortLostError, match="opened again"):
        bus.read(11, table.PRESENT_POSITION)
    assert not bus.is_open
    with pytest.raises(PortMissingError):
        bus.open()
    make_bench()
    with bus:
        assert bus.read(11, table.PRESENT_POSITION) == 2048
