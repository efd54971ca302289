"""Every fault of the bus and what becomes of it, in virtual time: recovery, or a typed error that says who, what and how much."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.actuators import ActuatorError, ActuatorState, WatchdogExpiredError
from drivers.dynamixel import control_table as table
from drivers.dynamixel import protocol
from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.errors import (
    CorruptAnswerError,
    HardwareError,
    NoAnswerError,
    RestartedError,
    StatusError,
)
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults
from drivers.simulated.servos.virtual_line import VirtualLine

CYCLE_S = 0.005
IDS = (11, 12, 21, 22, 30)
ALWAYS = frozenset(range(1, 10_000))
OVERLOAD = 0x20
FALSE_HEADER = bytes.fromhex("FF FF FD 00 0B F0 03")

AT_ONCE_S, WITHIN_A_CYCLE_S, TWO_CYCLES_S = 0.002, CYCLE_S, 2 * CYCLE_S
RECOVERED = {
    "nobody heard the question": (Faults(unheard={1}), WITHIN_A_CYCLE_S),
    "the common answer is lost": (Faults(drop={1, 2, 3, 4, 5}), WITHIN_A_CYCLE_S),
    "the first part is lost": (Faults(drop={1}), TWO_CYCLES_S),
    "a part in the middle is lost": (Faults(drop={3}), TWO_CYCLES_S),
    "the last part is lost": (Faults(drop={5}), TWO_CYCLES_S),
    "a part is truncated": (Faults(truncate={3}), TWO_CYCLES_S),
    "a part is garbled": (Faults(corrupt={2}), TWO_CYCLES_S),
    "all parts are garbled": (Faults(corrupt={1, 2, 3, 4, 5}), TWO_CYCLES_S),
    "a part comes twice": (Faults(double={3}), TWO_CYCLES_S),
    "the last part comes again a moment later": (Faults(double={5}, double_after_s=0.001), AT_ONCE_S),
    "noise ahead of the answer": (Faults(noise={1}), AT_ONCE_S),
    "noise between parts": (Faults(noise={3}), TWO_CYCLES_S),
    "noise that looks like a header": (Faults(noise={1}, noise_bytes=FALSE_HEADER), AT_ONCE_S),
    "noise, and the retry is lost too": (Faults(noise={2}, drop={6, 7}), TWO_CYCLES_S),
    "the answer is late by less than it may": (Faults(delay={1}, delay_s=0.001), WITHIN_A_CYCLE_S),
    "the answer comes after the question was repeated": (
        Faults(delay={1, 2, 3, 4, 5}, delay_s=0.0025),
        TWO_CYCLES_S,
    ),
}
"""What passes, and when the reading is there all the same; the wire alone takes 1.4 ms, and 1.6 ms for a repetition."""


@pytest.mark.parametrize("fault", RECOVERED)
def test_a_passing_fault_is_made_up_for(line, drive, fault):
    faults, within_s = RECOVERED[fault]
    drive.read()
    line.servos.set_faults(faults)
    began_s = line.now_s()
    state = drive.read()
    assert np.array_equal(state.displacement_mm, np.zeros(4))
    assert line.now_s() - began_s < within_s
    line.servos.set_faults(Faults())
    for _ in range(3):
        assert np.array_equal(drive.read().voltage_v, np.full(5, 12.0))


LASTING = {
    "everything is lost": (Faults(unheard=ALWAYS), NoAnswerError, "servo 11, 12, 21, 22, 30 within 6. ms"),
    "a servo is silent": (
        Faults(silent={21}),
        NoAnswerError,
        r"servo 21 within 6. ms; servos \[11, 12, 22, 30\] answered",
    ),
    "every answer is garbled": (Faults(corrupt=ALWAYS), CorruptAnswerError, "received instead: ff ff fd 00"),
    "every answer is truncated": (Faults(truncate=ALWAYS), CorruptAnswerError, "received instead"),
    "every answer is later than it may": (
        Faults(delay=ALWAYS, delay_s=0.2),
        NoAnswerError,
        "no answer from servo 11, 12",
    ),
    "nothing but noise": (
        Faults(truncate=ALWAYS, noise=ALWAYS, noise_bytes=FALSE_HEADER),
        CorruptAnswerError,
        "noise on the line, or two servos with one id",
    ),
}


@pytest.mark.parametrize("fault", LASTING)
def test_a_lasting_fault_is_a_typed_error_in_bounded_time(line, drive, fault):
    faults, kind, words = LASTING[fault]
    drive.read()
    line.servos.set_faults(faults)
    began_s, sent = line.now_s(), line.sent
    with pytest.raises(kind, match=words):
        drive.read()
    assert line.now_s() - began_s < 0.08
    assert line.sent - sent == 3
    line.servos.set_faults(Faults())
    line.pause(0.5)
    assert drive.read().hardware_error == (0, 0, 0, 0, 0)


def test_answers_that_always_come_twice_do_no_harm(line, drive):
    line.servos.set_faults(Faults(double=ALWAYS, double_after_s=0.0015))
    drive.enable()
    for _ in range(5):
        assert drive.read().torque
        drive.write(np.zeros(4), 0.0)
    drive.disable()
    assert not drive.read().torque
    drive.close()
    drive.open()
    assert not any(servo.torque_enabled for servo in line.servos.servos)


@pytest.mark.parametrize("after_s", [0.0, 0.0002, 0.001])
def test_a_second_answer_is_not_taken_for_the_answer_to_another_question(line, drive, after_s):
    bus = drive._bus
    line.servos.set_faults(Faults(double={1}, double_after_s=after_s))
    assert bus.read(11, table.PRESENT_TEMPERATURE) == 28
    assert bus.read(11, table.OPERATING_MODE) == 5


def test_an_answer_to_the_cycle_before_is_not_taken_for_this_cycles(line, drive):
    drive.read()
    late, lost = set(range(1, 11)), set(range(11, 16))
    line.servos.set_faults(Faults(delay=late, delay_s=0.0025, drop=lost))
    drive.read()
    line.servos.servo(22).fail(OVERLOAD)
    assert drive.read().hardware_error == (0, 0, 0, OVERLOAD, 0)


def test_a_question_that_arrives_garbled_is_repeated(line, drive, monkeypatch):
    hear, heard = line.servos.receive, []

    def garble_the_first(data, *rest):
        heard.append(data)
        return hear(data if len(heard) > 1 else data[:-3] + b"\x55" + data[-2:], *rest)

    monkeypatch.setattr(line.servos, "receive", garble_the_first)
    assert drive._bus.read(11, table.OPERATING_MODE) == 5
    assert len(heard) == 2


def test_a_lost_goal_is_replaced_by_the_next(line, drive):
    drive.enable()
    line.servos.set_faults(Faults(unheard={1}))
    drive.write(np.full(4, 1.0), 0.0)
    drive.read()
    drive.write(np.full(4, 1.0), 0.0)
    line.run(0.15)
    assert (drive.read().displacement_mm > 0.3).all()


class TestTwoServosWithOneId:
    """Servo 12 has come to answer to 11 as well."""

    @pytest.fixture(autouse=True)
    def shared(self, line, drive):
        line.servos.servo(12).memory["present_position"] = 3000
        line.servos.servo(12).memory["id"] = 11

    def test_their_answers_collide_and_that_is_said(self, drive):
        with pytest.raises(
            CorruptAnswerError, match=r"servo 11, 12 .*two servos with one id.*servos .21, 22, 30. answered"
        ):
            drive.read()

    def test_alone_they_collide_too(self, drive):
        with pytest.raises(CorruptAnswerError, match=r"servo 11 .*two servos with one id"):
            drive._bus.read(11, table.PRESENT_POSITION)

    def test_what_both_say_alike_passes(self, drive):
        assert drive._bus.ping(11).model_number == 1020

    def test_they_are_relaxed_all_the_same(self, line, settings):
        for servo in line.servos.servos:
            servo.memory["torque_enable"] = 1
        with pytest.raises(NoAnswerError, match="servo 12"):
            TendonActuators(settings, line).open()
        assert not any(servo.torque_enabled for servo in line.servos.servos)


class TestErrorBits:
    """What a servo complains of is told whatever else happens."""

    def test_in_every_cycle(self, line, drive):
        line.servos.servo(22).fail(OVERLOAD)
        for _ in range(3):
            assert drive.read().hardware_error == (0, 0, 0, OVERLOAD, 0)

    def test_when_the_answer_needed_a_retry(self, line, drive):
        drive.read()
        line.servos.servo(22).fail(OVERLOAD)
        line.servos.set_faults(Faults(drop={2}))
        assert drive.read().hardware_error == (0, 0, 0, OVERLOAD, 0)
        assert drive._bus.alerts == {22}

    def test_beside_a_silent_servo(self, line, drive):
        line.servos.servo(22).fail(OVERLOAD)
        line.servos.set_faults(Faults(silent={11}))
        with pytest.raises(
            NoAnswerError, match=r"servo 11 .*servo 22 reports a hardware error; servo 22: overload"
        ):
            drive.read()
        assert drive._bus.alerts == {22}

    def test_beside_a_garbled_servo(self, line, drive):
        line.servos.servo(22).fail(OVERLOAD)
        line.servos.servo(21).memory["present_position"] = 3000
        line.servos.servo(30).memory["id"] = 21
        with pytest.raises(CorruptAnswerError, match=r"servo 21, 30 .*servo 22: overload"):
            drive.read()

    def test_beside_a_restart(self, line, drive):
        line.servos.servo(22).fail(OVERLOAD)
        line.servos.servo(11).reboot(line.now_s())
        line.pause(1.0)
        with pytest.raises(RestartedError, match=r"servo \[11\] restarted .*servo 22: overload"):
            drive.read()

    def test_beside_an_expired_watchdog(self, line, drive):
        drive.enable()
        line.servos.servo(22).fail(OVERLOAD)
        line.run(0.4)
        with pytest.raises(WatchdogExpiredError, match="200 ms and stopped; servo 22: overload"):
            drive.read()

    def test_beside_a_refusal(self, line, drive):
        line.servos.servo(22).fail(OVERLOAD)
        line.servos.servo(12).fail(OVERLOAD)
        with pytest.raises(
            StatusError, match=r"servo 11 refused .*error 7.*servo 22 refuses: .* and reports a hard"
        ):
            drive._bus.sync_read_bytes(IDS, 660, 10)
        with pytest.raises(StatusError, match=r"servo 12 refused to set .* and reports a hardware error"):
            drive._bus.write(12, table.PRESENT_POSITION, 0)

    def test_of_a_garbled_question_whose_repetition_nobody_answers(self, line):
        answers = iter([protocol.Instruction(11, protocol.Code.STATUS, b"\x83").to_bytes()])
        line.servos.receive = lambda *_: []
        line.open()
        receive, line.receive = line.receive, lambda deadline_s: next(answers, b"") or receive(deadline_s)
        with pytest.raises(
            StatusError, match=r"received the instruction garbled .error 3. and reports a hardw"
        ):
            DynamixelBus(line).ping(11)


def test_lasting_current_is_an_overload_and_is_told(line, drive):
    strong = line.servos.servo(12)
    strong.memory["goal_current"] = 1000
    drive.enable()
    for _ in range(40):
        line.run(0.05, load_torque_Nm=4.0)
        state = drive.read()
    assert state.hardware_error == (0, OVERLOAD, 0, 0, 0)
    assert not state.torque
    with pytest.raises(HardwareError, match="servo 12: overload; find the cause, then `nodal servos reboot`"):
        drive.enable()


def test_heat_is_told(line, drive):
    line.servos.servo(30).motor.temperature_C = 81.0
    line.run(0.01)
    state = drive.read()
    assert state.hardware_error == (0, 0, 0, 0, 0x04)
    assert state.temperature_c[4] == pytest.approx(81, abs=1)


def test_a_silent_servo_keeps_no_other_from_being_relaxed(line, drive):
    drive.enable()
    line.servos.set_faults(Faults(silent={12}, unheard={1}))
    with pytest.raises(NoAnswerError, match="servo 12"):
        drive.disable()
    assert [servo.torque_enabled for servo in line.servos.servos] == [False, True, False, False, False]


@st.composite
def troubles(draw):
    numbers = st.sets(st.integers(1, 40), max_size=12)
    kinds = ("unheard", "drop", "truncate", "corrupt", "noise", "double", "delay")
    return Faults(
        **{kind: frozenset(draw(numbers)) for kind in draw(st.sets(st.sampled_from(kinds), max_size=4))},
        noise_bytes=draw(st.binary(min_size=1, max_size=12) | st.just(FALSE_HEADER)),
        delay_s=draw(st.sampled_from([0.0005, 0.003, 0.03])),
        double_after_s=draw(st.sampled_from([0.0, 0.001])),
    )


def axis(name, servo):
    return AxisSettings(name=name, id=servo, mm_per_rad=5.0, min_mm=-6.0, max_mm=6.0, max_current_ma=800.0)


@given(faults=troubles())
def test_no_fault_of_the_line_gives_a_wrong_value_or_an_untyped_error(faults):
    line = VirtualLine(EmulatedServosSettings(link="virtual", ids=(1, 2, 3)))
    settings = ServoSettings(port="virtual", tendons=(axis("a", 1), axis("b", 2), axis("c", 3)))
    drive = TendonActuators(settings, line)
    drive.open()
    line.servos.set_faults(faults)
    for cycle in range(8):
        line.servos.servo(2).memory["present_position"] = 2048 + cycle
        line.pause(CYCLE_S)
        try:
            state = drive.read()
            drive.write(np.zeros(3), 0.0)
        except ActuatorError:
            continue
        assert isinstance(state, ActuatorState)
        assert set(state.displacement_mm[[0, 2]]) == {0.0}
        assert state.voltage_v.tolist() == [12.0] * 3
        behind = cycle - round(state.displacement_mm[1] / (5.0 * table.RAD_PER_TICK))
        assert 0 <= behind <= 1


def test_a_drive_without_a_stage(line, settings):
    drive = TendonActuators(msgspec.structs.replace(settings, stage=None), line)
    with drive:
        state = drive.read()
        assert (state.insertion_mm, state.insertion_mm_s) == (0.0, 0.0)
        assert len(state.current_ma) == len(state.hardware_error) == len(state.position_mm) == 4
        drive.enable()
        drive.write(np.zeros(4), 0.0)
        with pytest.raises(ActuatorError, match=r"insertion 0.5 mm must be 0: there is no stage"):
            drive.write(np.zeros(4), 0.5)
        with pytest.raises(ActuatorError, match="insertion nan mm"):
            drive.set_zero(np.zeros(4), np.nan)
        drive.set_zero(np.ones(4), 0.0)
        assert np.allclose(drive.read().displacement_mm, 1.0)
