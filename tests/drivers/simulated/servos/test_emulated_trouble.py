"""What can go wrong on the emulated bus: what the line carries then, byte for byte, and what the servos do."""

import itertools

import msgspec
import numpy as np
import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.servos.bus import ServoBus
from drivers.simulated.servos.errors import NoSuchServoError
from drivers.simulated.servos.line import overlaid
from drivers.simulated.servos.servo import OVERLOADED
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults

PING_1 = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PING_2 = bytes.fromhex("FF FF FD 00 02 03 00 01 19 72")
READ_POSITION_1 = bytes.fromhex("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15")
BYTE_S = 1e-5


def heard(bus, wire, **options):
    return b"".join(answer.data for answer in bus.receive(wire, 1.0, **options))


def test_equal_bytes_at_once_pass_and_others_are_pulled_low():
    assert overlaid([(0.0, b"\x55\x0f"), (0.0, b"\x55\xf3\x77")], BYTE_S) == [(0.0, b"\x55\x03\x77")]


def test_a_later_one_spoils_what_is_left_of_the_earlier():
    assert overlaid([(1e-3, b"\xff\x0f"), (1e-3 + BYTE_S, b"\xf1\x33")], BYTE_S) == [(1e-3, b"\xff\x01\x33")]


def test_those_that_do_not_touch_follow_each_other():
    (first, pause), (second, rest) = (
        (data, pause_s) for pause_s, data in overlaid([(1e-3, b"b"), (0.0, b"a")], BYTE_S)
    )
    assert (first, second) == (b"a", b"b")
    assert (pause, rest) == pytest.approx((0.0, 1e-3 - BYTE_S))


@given(st.lists(st.tuples(st.floats(0, 1e-3), st.binary(min_size=1, max_size=30)), max_size=4))
def test_the_line_is_busy_until_the_last_is_through(answers):
    line = overlaid(answers, BYTE_S)
    end_s = sum(pause_s + len(data) * BYTE_S for pause_s, data in line)
    assert end_s == pytest.approx(
        max((s + len(d) * BYTE_S for s, d in answers), default=0), abs=BYTE_S * len(answers)
    )
    assert all(pause_s >= 0 for pause_s, _ in line)


class TestTwoWithOneId:
    """Servo 2 has come to have the id 1."""

    @pytest.fixture(autouse=True)
    def shared(self, bus):
        bus.servo(2).memory["id"] = 1

    def test_alike_they_look_like_one(self, bus):
        assert heard(bus, PING_1) == heard(ServoBus(EmulatedServosSettings(link="x", ids=(1,))), PING_1)

    def test_different_they_spoil_each_other(self, bus):
        alone = heard(bus, READ_POSITION_1)
        bus.servos[1].memory["present_position"] = 3000
        assert len(heard(bus, READ_POSITION_1)) == len(alone) != alone

    def test_with_other_delays_both_are_heard(self, bus):
        bus.servos[1].memory["return_delay_time"] = 250
        answers = bus.receive(PING_1, 1.0)
        assert [answer.data for answer in answers] == [answers[0].data] * 2
        assert answers[1].delay_s == pytest.approx(500e-6 + 14 * BYTE_S)

    def test_both_obey(self, bus):
        led_on = bytes.fromhex("FF FF FD 00 01 06 00 03 41 00 01 CC E6")
        assert heard(bus, led_on)[8] == 0
        assert [servo.memory["led"] for servo in bus.servos] == [1, 1, 0]


def test_faults_come_one_after_another(bus):
    good = heard(bus, PING_1)
    bus.set_faults(Faults(unheard={1}, noise={1}, noise_bytes=b"\x01\x02", double={2}, double_after_s=0.25))
    assert bus.receive(PING_1, 1.0) == []
    assert heard(bus, PING_1) == b"\x01\x02" + good
    once, again = bus.receive(PING_1, 1.0)
    assert once.data == again.data == good
    assert again.delay_s - once.delay_s == pytest.approx(0.25)


def test_a_client_at_another_speed_is_not_heard(bus):
    assert heard(bus, PING_1, baud_rate=57_600) == b""
    bus.servo(1).memory["baud_rate"] = 1
    slow = bus.receive(PING_1, 1.0, baud_rate=57_600)
    assert slow[0].delay_s == pytest.approx(140 / 57_600)
    assert heard(bus, PING_1) == b""
    assert heard(bus, PING_2)


@pytest.mark.parametrize(("load_Nm", "overloads"), [(4.0, True), (1.0, False)])
def test_lasting_current_is_an_overload(bus, load_Nm, overloads):
    bus.servo(1).memory["torque_enable"] = 1
    for step in range(150):
        bus.step(0.01, [load_Nm, 0.0, 0.0], 1.0 + 0.01 * step)
    assert (bus.servo(1).memory["hardware_error_status"] == OVERLOADED) == overloads
    assert bus.servo(1).torque_enabled != overloads


def test_a_peak_is_no_overload(bus):
    bus.servo(1).memory["torque_enable"] = 1
    for step, load_Nm in enumerate(itertools.chain(*[[4.0] * 90, [0.0] * 30] * 3)):
        bus.step(0.01, [load_Nm, 0.0, 0.0], 1.0 + 0.01 * step)
    assert bus.servo(1).memory["hardware_error_status"] == 0


def test_a_speed_that_no_servo_has_is_refused():
    with pytest.raises(msgspec.ValidationError, match="baud_rate 500000: servos speak at 9600, 57600"):
        msgspec.convert({"link": "x", "ids": [1], "baud_rate": 500_000}, EmulatedServosSettings)


def test_a_servo_that_is_not_there_is_named(servos):
    for use in (lambda: servos.fail(9, 1), lambda: servos.restart(9), lambda: servos.set_registers(9, led=1)):
        with pytest.raises(NoSuchServoError, match=r"no servo 9 on the emulated bus; there are \[1, 2, 3\]"):
            use()


def test_the_speed_of_a_client_is_seen_on_the_device(servos, settings):
    servos.set_registers(2, baud_rate=7)
    with serial.Serial(settings.link, 4_500_000, timeout=5, exclusive=True) as port:
        port.write(PING_1 + PING_2)
        assert port.read(14)[4] == 2


def test_unplugged_servos_go_on_turning_and_are_there_again(servos, settings):
    servos.set_registers(1, led=1)
    with serial.Serial(settings.link, 1_000_000):
        servos.unplug()
        assert servos.step(0.01, np.zeros(3)).shape == (3,)
        servos.plug_in()
    with serial.Serial(settings.link, 1_000_000, timeout=5, exclusive=True) as port:
        port.write(PING_1)
        assert port.read(14)[4] == 1
    assert servos.registers(1, "led", "id") == (1, 1)
