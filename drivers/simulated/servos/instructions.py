"""What emulated servos do when instructed, alone or as a group, and what they answer."""

import enum
from collections.abc import Iterator, Mapping, Sequence

from drivers.simulated.servos import packets
from drivers.simulated.servos.line import TimedBytes, overlaid
from drivers.simulated.servos.memory import INSTRUCTION_ERROR, LENGTH_ERROR, InstructionRefusedError
from drivers.simulated.servos.packets import Received
from drivers.simulated.servos.servo import Servo

Listeners = Mapping[int, Sequence[Servo]]
"""The servos that listen, by id; two that share one answer at once."""


class Single(enum.IntEnum):
    """Instructions to one servo, or to each of all."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    REBOOT = 0x08
    CLEAR = 0x10


class Group(enum.IntEnum):
    """Instructions whose parameters name the servos."""

    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93


def status(servo: Servo, error: int, parameters: bytes = b"") -> TimedBytes:
    """One servo's status packet."""
    return servo.return_delay_s, packets.status(servo.id, error | servo.alert, parameters)


def obey(servo: Servo, packet: Received, now_s: float) -> list[TimedBytes]:
    """One servo carries out an instruction; it answers when its status return level lets it."""
    level = servo.memory["status_return_level"]
    answers = packet.code == Single.PING or level == 2 or (level == 1 and packet.code == Single.READ)
    try:
        answer = status(servo, 0, _carry_out(servo, packet, now_s))
    except InstructionRefusedError as refusal:
        answer = status(servo, refusal.number)
    return [answer] if answers else []


def obey_together(packet: Received, servos: Listeners, byte_s: float) -> list[TimedBytes]:
    """Several servos carry out an instruction; none answers a malformed one, or a write."""
    parameters = packet.parameters
    readers = {
        servo_id: [servo for servo in sharing if servo.memory["status_return_level"] > 0]
        for servo_id, sharing in servos.items()
    }
    try:
        match packet.code:
            case Group.SYNC_READ:
                return _read_in_turn([(i, parameters[:4]) for i in parameters[4:]], readers, byte_s)
            case Group.BULK_READ:
                parts = [parameters[n : n + 5] for n in range(0, len(parameters), 5)]
                return _read_in_turn([(part[0], part[1:]) for part in parts], readers, byte_s)
            case Group.FAST_SYNC_READ:
                return _read_as_one(parameters[4:], parameters[:4], readers, byte_s)
            case Group.SYNC_WRITE:
                writes = _sync_writes(parameters)
            case _:
                writes = _bulk_writes(parameters)
        for servo_id, address, data in writes:
            for servo in servos.get(servo_id, ()):
                _write_quietly(servo, address, data)
    except InstructionRefusedError:
        return []
    return []


def _carry_out(servo: Servo, packet: Received, now_s: float) -> bytes:
    parameters = packet.parameters
    match packet.code:
        case Single.PING:
            return servo.memory.read(0, 2) + servo.memory.read(6, 1)
        case Single.READ:
            return servo.memory.read(_word(parameters, 0), _word(parameters, 2))
        case Single.WRITE:
            servo.write(_word(parameters, 0), parameters[2:])
        case Single.REG_WRITE:
            servo.register_write(_word(parameters, 0), parameters[2:])
        case Single.ACTION:
            servo.action()
        case Single.CLEAR:
            servo.clear(parameters)
        case Single.REBOOT:
            servo.reboot(now_s)
        case _:
            raise InstructionRefusedError(INSTRUCTION_ERROR)
    return b""


def _read_in_turn(wanted: list[tuple[int, bytes]], servos: Listeners, byte_s: float) -> list[TimedBytes]:
    return [
        answer
        for servo_id, place in wanted
        for answer in overlaid(
            [status(servo, *_read(servo, place)) for servo in servos.get(servo_id, ())], byte_s
        )
    ]


def _read_as_one(ids: bytes, place: bytes, servos: Listeners, byte_s: float) -> list[TimedBytes]:
    """One packet from all: each servo waits for the one before it, so a silent one silences those behind it."""
    size = _word(place, 2)
    if len(ids) * (size + packets.FAST_PART_EXTRA) >= packets.LENGTH_END:
        return []
    packet = packets.fast_status_start(len(ids), size)
    answers: list[TimedBytes] = []
    for servo_id in ids:
        if not (sharing := servos.get(servo_id)):
            break
        delay_s = 0.0 if answers else min(servo.return_delay_s for servo in sharing)
        sent = len(packet) if answers else 0
        parts = [packets.append_crc(packet + _part(servo, place, size))[sent:] for servo in sharing]
        for _, heard in overlaid([(0.0, part) for part in parts], byte_s):
            packet = packet[:sent] + heard
            answers.append((delay_s, heard))
    return answers


def _part(servo: Servo, place: bytes, size: int) -> bytes:
    error, block = _read(servo, place)
    return bytes((error | servo.alert, servo.id)) + block.ljust(size, b"\0")


def _sync_writes(parameters: bytes) -> Iterator[tuple[int, int, bytes]]:
    address, size = _word(parameters, 0), _word(parameters, 2)
    for n in range(4, len(parameters) - size, size + 1):
        yield parameters[n], address, parameters[n + 1 : n + 1 + size]


def _bulk_writes(parameters: bytes) -> Iterator[tuple[int, int, bytes]]:
    while len(parameters) > 5:
        size = _word(parameters, 3)
        yield parameters[0], _word(parameters, 1), parameters[5 : 5 + size]
        parameters = parameters[5 + size :]


def _write_quietly(servo: Servo, address: int, data: bytes) -> None:
    try:
        servo.write(address, data)
    except InstructionRefusedError:
        return  # nobody answers a sync or bulk write, not even to refuse it


def _read(servo: Servo, place: bytes) -> tuple[int, bytes]:
    try:
        return 0, servo.memory.read(_word(place, 0), _word(place, 2))
    except InstructionRefusedError as refusal:
        return refusal.number, b""


def _word(parameters: bytes, at: int) -> int:
    if len(parameters) < at + 2:
        raise InstructionRefusedError(LENGTH_ERROR)
    return parameters[at] | parameters[at + 1] << 8
