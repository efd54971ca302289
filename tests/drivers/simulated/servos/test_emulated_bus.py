"""The emulated bus byte for byte: the e-manual's examples, its rules of access, its watchdog, and nonsense."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.servos.bus import ServoBus
from drivers.simulated.servos.packets import append_crc, checksum
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults

OK, RESULT_FAIL, INSTRUCTION, CRC, RANGE, LENGTH, LIMIT, ACCESS = range(8)


def ask(bus, wire, now_s=1.0):
    """Everything the line carries in answer."""
    data = bytes.fromhex(wire) if isinstance(wire, str) else wire
    return b"".join(answer.data for answer in bus.receive(data, now_s))


def instruction(servo, code, parameters=b""):
    body = bytes((code,)) + parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    return append_crc(b"\xff\xff\xfd\x00" + bytes((servo,)) + (len(body) + 2).to_bytes(2, "little") + body)


def write(bus, servo, address, data, now_s=1.0):
    """Write and return the error byte of the answer."""
    return ask(bus, instruction(servo, 0x03, address.to_bytes(2, "little") + bytes(data)), now_s)[8]


def read(bus, servo, address, size, now_s=1.0):
    answer = ask(
        bus, instruction(servo, 0x02, address.to_bytes(2, "little") + size.to_bytes(2, "little")), now_s
    )
    return answer[8], answer[9:-2]


def run(bus, seconds, load_Nm=0.0, start_s=1.0):
    for n in range(round(seconds / 0.01)):
        bus.step(0.01, [load_Nm] * len(bus.servos), start_s + n * 0.01)


def position(bus, now_s=1.0):
    return int.from_bytes(read(bus, 1, 132, 4, now_s)[1], "little", signed=True)


FRICTION_TICKS = 4
"""How far from its goal friction lets a servo rest."""


def goal(ticks):
    return ticks.to_bytes(4, "little", signed=True)


def like_the_e_manuals(ids, **settings):
    return ServoBus(EmulatedServosSettings(link="x", ids=ids, model_number=1030, firmware=38, **settings))


def test_ping_answers_as_in_the_e_manual():
    bus = like_the_e_manuals((1, 2))
    first = "ff ff fd 00 01 07 00 55 00 06 04 26 65 5d"
    second = "ff ff fd 00 02 07 00 55 00 06 04 26 6f 6d"
    assert ask(bus, "FF FF FD 00 01 03 00 01 19 4E").hex(" ") == first
    assert ask(bus, "FF FF FD 00 FE 03 00 01 31 42").hex(" ") == f"{first} {second}"


def test_reads_answer_as_in_the_e_manual():
    bus = like_the_e_manuals((1, 2))
    bus.servos[0].memory["present_position"] = 166
    bus.servos[1].memory["present_position"] = 2079
    first = "ff ff fd 00 01 08 00 55 00 a6 00 00 00 8c c0"
    second = "ff ff fd 00 02 08 00 55 00 1f 08 00 00 ba be"
    assert ask(bus, "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15").hex(" ") == first
    assert ask(bus, "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA").hex(" ") == f"{first} {second}"


def test_bulk_read_answers_as_in_the_e_manual():
    bus = like_the_e_manuals((1, 2))
    bus.servos[0].memory["present_input_voltage"] = 119
    bus.servos[1].memory["present_temperature"] = 36
    wire = "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05"
    expected = "ff ff fd 00 01 06 00 55 00 77 00 c3 69 ff ff fd 00 02 05 00 55 00 24 8b a9"
    assert ask(bus, wire).hex(" ") == expected


def test_fast_sync_read_answers_as_in_the_e_manual():
    bus = like_the_e_manuals((3, 4, 7))
    for servo, position in zip(bus.servos, (166, 1023, 2079), strict=True):
        servo.memory["present_position"] = position
    expected = (
        "ff ff fd 00 fe 19 00 55 00 03 a6 00 00 00 84 08 00 07 1f 08 00 00 16 ca 00 04 ff 03 00 00 d1 9e"
    )
    assert ask(bus, "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2").hex(" ") == expected


@pytest.mark.parametrize(
    ("wire", "name", "value"),
    [
        ("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89", "goal_position", 512),
        ("FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87", "goal_position", 150),
        ("FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68", "max_voltage_limit", 160),
    ],
)
def test_writes_do_as_in_the_e_manual(bus, wire, name, value):
    ask(bus, wire)
    assert bus.servos[0].memory[name] == value


def test_a_registered_write_waits_for_action(bus):
    acknowledged = "ff ff fd 00 01 04 00 55 00 a1 0c"
    assert ask(bus, "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E").hex(" ") == acknowledged
    memory = bus.servos[0].memory
    assert (memory["goal_velocity"], memory["registered_instruction"]) == (350, 1)
    assert ask(bus, "FF FF FD 00 01 03 00 05 02 CE").hex(" ") == acknowledged
    assert (memory["goal_velocity"], memory["registered_instruction"]) == (200, 0)
    assert ask(bus, "FF FF FD 00 01 03 00 05 02 CE")[8] == INSTRUCTION


def test_crc_has_the_check_value_of_its_family():
    assert checksum(b"123456789") == 0xFEE8  # CRC-16/BUYPASS: polynomial 0x8005, start 0, not reflected


@pytest.mark.parametrize(
    ("address", "data", "error"),
    [
        (116, goal(-5000), OK),
        (64, [1], OK),
        (64, [2], RANGE),
        (112, goal(32768), RANGE),
        (102, (1194).to_bytes(2, "little"), LIMIT),
        (104, goal(351), LIMIT),
        (116, b"\0\0", LENGTH),
        (116, b"", LENGTH),
        (132, goal(0), ACCESS),
        (117, b"\0", ACCESS),
        (66, b"\0", ACCESS),
        (700, b"\0", ACCESS),
        (11, [4], OK),
        (11, [2], RANGE),
        (108, bytes(8) + goal(3000), OK),
        (108, bytes(8) + goal(2_000_000), RANGE),
    ],
)
def test_writes_obey_the_rules_of_access(bus, address, data, error):
    before = bus.servos[0].memory.read(0, 660)
    assert write(bus, 1, address, data) == error
    assert (bus.servos[0].memory.read(0, 660) == before) == bool(error)


def test_eeprom_is_locked_while_torque_is_on(bus):
    assert write(bus, 1, 64, [1]) == OK
    assert write(bus, 1, 9, [0]) == ACCESS
    assert write(bus, 1, 64, [0]) == OK
    assert write(bus, 1, 9, [0]) == OK


def test_goals_within_one_turn_are_limited_in_position_mode(bus):
    write(bus, 1, 11, [3])
    assert write(bus, 1, 116, goal(4096)) == LIMIT
    assert write(bus, 1, 116, goal(4095)) == OK


def test_a_header_inside_an_answer_is_stuffed(bus):
    write(bus, 1, 224, b"\xff\xff\xfd\x00")
    answer = ask(bus, instruction(1, 0x02, bytes((224, 0, 4, 0))))
    assert answer[5:-2] == bytes.fromhex("09 00 55 00 FF FF FD FD 00")


@pytest.mark.parametrize("size", [662, 663, 40_000, 65_535])
def test_a_fast_read_of_more_than_a_packet_holds_is_left_unanswered(bus, size):
    wire = instruction(254, 0x8A, b"\0\0" + size.to_bytes(2, "little") + bytes((1, 2, 3)))
    assert bool(ask(bus, wire)) == (3 * size < 65_000)


def test_reads_outside_the_table_are_refused(bus):
    assert read(bus, 1, 0, 662)[0] == OK
    assert read(bus, 1, 1, 662)[0] == ACCESS
    assert read(bus, 1, 65535, 65535)[0] == ACCESS


def test_indirect_data_shows_and_writes_what_it_points_to(bus):
    assert (
        write(bus, 1, 168, b"".join(place.to_bytes(2, "little") for place in (116, 117, 118, 119, 146))) == OK
    )
    assert write(bus, 1, 224, goal(-7)) == OK
    assert bus.servos[0].memory["goal_position"] == -7
    assert read(bus, 1, 224, 5) == (OK, goal(-7) + bytes((28,)))


@pytest.mark.parametrize(
    ("level", "answers"), [(0, (True, False, False)), (1, (True, True, False)), (2, (True,) * 3)]
)
def test_status_return_level_says_what_is_answered(bus, level, answers):
    ask(bus, instruction(1, 0x03, bytes((68, 0, level))))
    asked = (
        instruction(1, 0x01),
        instruction(1, 0x02, bytes((132, 0, 4, 0))),
        instruction(1, 0x03, bytes((65, 0, 1))),
    )
    assert tuple(bool(ask(bus, wire)) for wire in asked) == answers


def test_answers_wait_for_the_return_delay_and_the_wire():
    bus = like_the_e_manuals((1, 2), return_delay_us=500, baud_rate=1_000_000)
    delays = [
        answer.delay_s for answer in bus.receive(instruction(254, 0x82, bytes((132, 0, 4, 0, 1, 2))), 1.0)
    ]
    assert delays == pytest.approx([500e-6 + 150e-6, 1000e-6 + 300e-6])


def test_a_garbled_instruction_is_answered_as_such(bus):
    wire = bytearray(instruction(1, 0x03, bytes((65, 0, 1))))
    wire[10] ^= 1
    assert ask(bus, bytes(wire))[8] == CRC
    assert bus.servos[0].memory["led"] == 0


def test_an_unknown_instruction_is_answered_as_such(bus):
    assert ask(bus, instruction(1, 0x77))[8] == INSTRUCTION


def test_broadcast_writes_reach_all_and_nobody_answers(bus):
    assert ask(bus, instruction(254, 0x03, bytes((65, 0, 1)))) == b""
    assert [servo.memory["led"] for servo in bus.servos] == [1, 1, 1]


def test_a_servo_whose_id_was_changed_answers_to_the_new_one(bus):
    assert write(bus, 1, 7, [9]) == OK
    assert ask(bus, instruction(1, 0x01)) == b""
    assert ask(bus, instruction(9, 0x01))


def test_a_hardware_error_takes_torque_sets_the_alert_and_needs_a_reboot(bus):
    write(bus, 1, 64, [1])
    bus.servos[0].fail(0x20)
    assert not bus.servos[0].torque_enabled
    assert read(bus, 1, 70, 1) == (0x80, b"\x20")
    assert write(bus, 1, 64, [1]) == 0x80 | ACCESS
    assert ask(bus, instruction(1, 0x08), now_s=5.0)
    assert ask(bus, instruction(1, 0x01), now_s=5.1) == b""
    assert read(bus, 1, 70, 1, now_s=5.3) == (OK, b"\0")
    assert write(bus, 1, 64, [1], now_s=5.3) == OK


def test_a_reboot_forgets_ram_and_turns_but_not_eeprom(bus):
    write(bus, 1, 31, [70])
    write(bus, 1, 112, goal(100))
    write(bus, 1, 64, [1])
    write(bus, 1, 116, goal(2048 + 3 * 4096))
    run(bus, 20)
    assert position(bus) == pytest.approx(2048 + 3 * 4096, abs=FRICTION_TICKS)
    within_turn = position(bus) - 3 * 4096
    angle = bus.servos[0].motor.position_rad
    ask(bus, instruction(1, 0x08), now_s=30.0)
    assert position(bus, now_s=31.0) == within_turn
    assert read(bus, 1, 116, 4, now_s=31.0)[1] == goal(within_turn)
    assert read(bus, 1, 112, 4, now_s=31.0)[1] == goal(0)
    assert read(bus, 1, 31, 1, now_s=31.0)[1] == bytes((70,))
    run(bus, 1, start_s=31.0)
    assert bus.servos[0].motor.position_rad == pytest.approx(angle)


def test_clear_forgets_turns_only_at_rest(bus):
    write(bus, 1, 64, [1])
    write(bus, 1, 116, goal(2048 + 4096))
    run(bus, 0.3)
    clear = instruction(1, 0x10, b"\x01DXL\x22")
    assert ask(bus, clear)[8] == RESULT_FAIL
    run(bus, 5)
    assert ask(bus, clear)[8] == OK
    assert position(bus) == pytest.approx(2048, abs=FRICTION_TICKS)


class TestWatchdog:
    """Units of 20 ms, armed with torque on, fed by any instruction, cleared by 0 alone."""

    @pytest.fixture(autouse=True, params=[20, 0], ids=["with profile", "without profile"])
    def moving(self, bus, request):
        write(bus, 1, 112, goal(request.param))
        write(bus, 1, 64, [1])
        write(bus, 1, 98, [5])
        write(bus, 1, 116, goal(20_000))
        run(bus, 0.09)

    def expire(self, bus):
        run(bus, 0.5, start_s=1.09)

    def test_silence_stops_the_servo(self, bus):
        self.expire(bus)
        assert read(bus, 1, 98, 1, now_s=1.6) == (OK, b"\xff")
        stopped = bus.servos[0].motor.position_rad
        run(bus, 1, start_s=1.6)
        assert bus.servos[0].motor.position_rad == pytest.approx(stopped, abs=1e-3)

    @pytest.mark.parametrize("packet", [instruction(1, 0x02, bytes((132, 0, 4, 0))), instruction(2, 0x01)])
    def test_any_instruction_to_anyone_feeds_it(self, bus, packet):
        for n in range(20):
            ask(bus, packet, now_s=1.09 + n * 0.09)
            run(bus, 0.09, start_s=1.09 + n * 0.09)
        assert bus.servos[0].memory["bus_watchdog"] == 5

    def test_it_is_not_armed_without_torque(self, bus):
        write(bus, 1, 64, [0])
        run(bus, 5)
        assert bus.servos[0].memory["bus_watchdog"] == 5

    @pytest.mark.parametrize(("address", "size"), [(100, 2), (102, 2), (104, 4), (116, 4)])
    def test_goals_are_refused_until_it_is_cleared(self, bus, address, size):
        self.expire(bus)
        assert write(bus, 1, address, bytes(size), now_s=2.0) == RANGE
        assert write(bus, 1, 98, [5], now_s=2.0) == RANGE
        assert write(bus, 1, 98, [0], now_s=2.0) == OK
        assert write(bus, 1, address, bytes(size), now_s=2.0) == OK


def test_a_silent_servo_silences_those_behind_it_only_in_a_fast_read(bus):
    bus.set_faults(Faults(silent=frozenset({2})))
    assert len(ask(bus, instruction(254, 0x82, bytes((132, 0, 4, 0, 1, 2, 3))))) == 2 * 15
    assert len(ask(bus, instruction(254, 0x8A, bytes((132, 0, 4, 0, 1, 2, 3))))) == 16
    assert ask(bus, instruction(2, 0x01)) == b""


def test_faults_spoil_the_answers_they_name(bus):
    ping = instruction(1, 0x01)
    good = ask(bus, ping)
    bus.set_faults(Faults(drop={1}, truncate={2}, corrupt={3}, delay={4}, delay_s=0.5))
    dropped, truncated, corrupt, delayed, last = (bus.receive(ping, 1.0) for _ in range(5))
    assert dropped == []
    assert truncated[0].data == good[:7]
    assert len(corrupt[0].data) == len(good)
    assert append_crc(corrupt[0].data[:-2]) != corrupt[0].data
    assert delayed[0].delay_s - last[0].delay_s == pytest.approx(0.5)
    assert last[0].data == good


shreds = st.sampled_from([b"\xff\xff\xfd\x00", b"\xff\xff\xfd", b"\x01\x03\x00", b"\xfe\x09\x00\x82"])
nonsense = st.lists(shreds | st.binary(max_size=8), max_size=20).map(b"".join)
instructions = st.builds(
    instruction,
    st.sampled_from([1, 2, 3, 9, 254]),
    st.sampled_from([*range(0x12), 0x82, 0x83, 0x8A, 0x92, 0x93]),
    st.binary(max_size=20),
)


@given(data=st.lists(nonsense | instructions, max_size=10))
def test_it_survives_whatever_a_client_sends(data):
    bus = ServoBus(EmulatedServosSettings(link="x", ids=(1, 2, 3)))
    for now_s, wire in enumerate(data):
        bus.receive(wire, float(now_s))
        bus.step(0.005, [0.1, -0.1, 0.0], float(now_s))
    ask(bus, bytes(4096), 98.0)
    for servo in bus.servos:
        assert ask(bus, instruction(servo.id, 0x01), 99.0)


@given(
    cuts=st.sets(st.integers(1, 25)), rubbish=st.binary(max_size=10).filter(lambda data: b"\xff" not in data)
)
def test_instructions_survive_any_split_and_rubbish_between(cuts, rubbish):
    bus = ServoBus(EmulatedServosSettings(link="x", ids=(1, 2, 3)))
    wire = instruction(1, 0x01) + rubbish + instruction(2, 0x01)
    edges = [0, *sorted(cut for cut in cuts if cut < len(wire)), len(wire)]
    answers = b"".join(ask(bus, wire[a:b]) for a, b in itertools.pairwise(edges))
    assert [answers[4], answers[18]] == [1, 2]
