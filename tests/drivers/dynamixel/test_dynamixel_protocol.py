"""Packets against the e-manual's own examples, and the parser against everything a line can do."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel import protocol
from drivers.dynamixel.protocol import Dropped, FastStatusPacket, Instruction, PacketParser, StatusPacket

E_MANUAL_INSTRUCTIONS = [
    (protocol.ping(1), "FF FF FD 00 01 03 00 01 19 4E"),
    (protocol.ping(254), "FF FF FD 00 FE 03 00 01 31 42"),
    (protocol.read(1, 132, 4), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    (protocol.write(1, 116, bytes((0, 2, 0, 0))), "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    (protocol.reboot(1), "FF FF FD 00 01 03 00 08 2F 4E"),
    (protocol.sync_read([1, 2], 132, 4), "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    (
        protocol.sync_write(116, {1: bytes((150, 0, 0, 0)), 2: bytes((170, 0, 0, 0))}),
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    (protocol.fast_sync_read([3, 7, 4], 132, 4), "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"),
]
E_MANUAL_ANSWERS = [
    (StatusPacket(1, 0, False, bytes((0x06, 0x04, 0x26))), "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    (StatusPacket(2, 0, False, bytes((0x06, 0x04, 0x26))), "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    (StatusPacket(1, 0, False, bytes((0xA6, 0, 0, 0))), "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    (StatusPacket(2, 0, False, bytes((0x1F, 8, 0, 0))), "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    (StatusPacket(1, 0, False), "FF FF FD 00 01 04 00 55 00 A1 0C"),
]
FAST_ANSWER = bytes.fromhex(
    "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
)
FAST_ANSWERS = [
    StatusPacket(3, 0, False, bytes((0xA6, 0, 0, 0))),
    StatusPacket(7, 0, False, bytes((0x1F, 8, 0, 0))),
    StatusPacket(4, 0, False, bytes((0xFF, 3, 0, 0))),
]

ids = st.integers(0, protocol.MAX_ID)
parameters = st.lists(
    st.sampled_from([b"\xff", b"\xfd", b"\x00", b"\x55", b"\xff\xff\xfd", b"\xff\xff\xfd\x00"])
    | st.binary(max_size=4),
    max_size=12,
).map(b"".join)
packets = st.builds(Instruction, ids, st.sampled_from([0x01, 0x02, 0x03, 0x82]), parameters)


def packets_in(events):
    return [event for event in events if not isinstance(event, Dropped)]


def dropped_in(events):
    return b"".join(event.data for event in events if isinstance(event, Dropped))


def status(servo, error, data=b""):
    """A status packet's bytes: what an instruction packet with code 0x55 looks like."""
    return Instruction(servo, protocol.Code.STATUS, bytes((error,)) + data).to_bytes()


@pytest.mark.parametrize(("instruction", "wire"), E_MANUAL_INSTRUCTIONS)
def test_instructions_have_the_bytes_of_the_e_manual(instruction, wire):
    assert instruction.to_bytes() == bytes.fromhex(wire)
    assert PacketParser().receive(bytes.fromhex(wire)) == [instruction]


@pytest.mark.parametrize(("answer", "wire"), E_MANUAL_ANSWERS)
def test_answers_of_the_e_manual_are_understood(answer, wire):
    assert PacketParser().receive(bytes.fromhex(wire)) == [answer]


def test_the_fast_answer_of_the_e_manual_is_understood():
    assert PacketParser().receive(FAST_ANSWER) == [FastStatusPacket(FAST_ANSWER)]
    assert protocol.split_fast_status(FAST_ANSWER, 4) == FAST_ANSWERS


@pytest.mark.parametrize("length", range(len(FAST_ANSWER) + 1))
def test_of_a_fast_answer_cut_short_the_whole_parts_are_kept(length):
    whole = protocol.salvage_fast_status(b"\xff\x00" + FAST_ANSWER[:length], 4)
    assert protocol.split_fast_status(whole, 4) == FAST_ANSWERS[: max(0, length - 8) // 8]


@pytest.mark.parametrize("at", range(8, len(FAST_ANSWER)))
def test_of_a_garbled_fast_answer_only_the_parts_ahead_of_the_damage_are_kept(at):
    garbled = bytearray(FAST_ANSWER)
    garbled[at] ^= 0x10
    whole = protocol.salvage_fast_status(bytes(garbled), 4)
    assert protocol.split_fast_status(whole, 4) == FAST_ANSWERS[: (at - 8) // 8]


def test_the_alert_bit_is_told_from_the_error_number():
    assert PacketParser().receive(status(7, 0x84, b"x")) == [StatusPacket(7, 4, True, b"x")]


def test_a_header_inside_parameters_is_stuffed():
    wire = protocol.write(1, 116, b"\xff\xff\xfd\x00").to_bytes()
    assert b"\xff\xff\xfd\xfd\x00" in wire[7:]
    assert wire[5] == 10


@given(packet=packets)
def test_packets_survive_the_wire(packet):
    assert PacketParser().receive(packet.to_bytes()) == [packet]


@given(first=packets, second=packets, data=st.data())
def test_packets_survive_any_split(first, second, data):
    wire = first.to_bytes() + FAST_ANSWER + second.to_bytes()
    cuts = sorted(data.draw(st.sets(st.integers(0, len(wire)))))
    parser = PacketParser()
    events = []
    for start, end in zip([0, *cuts], [*cuts, len(wire)], strict=True):
        events += parser.receive(wire[start:end])
    assert events == [first, FastStatusPacket(FAST_ANSWER), second]


@given(rubbish=st.binary(max_size=40), packet=packets, more=st.binary(max_size=40))
def test_rubbish_is_reported_and_hides_no_packet(rubbish, packet, more):
    parser = PacketParser()
    wire = rubbish + packet.to_bytes() + more
    events = [event for byte in wire for event in parser.receive(bytes((byte,)))] + parser.give_up_waiting()
    assert packet in events
    found = b"".join(event.to_bytes() for event in events if isinstance(event, Instruction))
    assert len(found) + len(dropped_in(events)) == len(wire)


@given(data=st.binary(max_size=300))
def test_no_byte_is_lost_in_silence(data):
    parser = PacketParser()
    events = parser.receive(data) + parser.give_up_waiting()
    if not packets_in(events):
        assert dropped_in(events) == data


@pytest.mark.parametrize(
    "false_header", ["FF FF FD 00 01 50 00", "FF FF FD 00 01 FF FF", "FF FF FD 00 FD 04 00", "FF FF FD"]
)
def test_a_false_header_hides_the_packet_behind_it_no_longer_than_the_deadline(false_header):
    parser = PacketParser()
    events = parser.receive(bytes.fromhex(false_header) + status(3, 0)) + parser.give_up_waiting()
    assert packets_in(events) == [StatusPacket(3, 0, False)]
    assert dropped_in(events) == bytes.fromhex(false_header)


@pytest.mark.parametrize("at", range(4, 14))
def test_no_damaged_packet_passes(at):
    wire = bytearray(status(1, 0, b"\x06\x04\x26"))
    wire[at] ^= 0x01
    parser = PacketParser()
    assert packets_in(parser.receive(bytes(wire)) + parser.give_up_waiting()) == []
