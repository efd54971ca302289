"""Dynamixel Protocol 2.0 without I/O: bytes in, packets out.

A packet is FF FF FD 00, id, length (of what follows it), instruction, parameters, CRC-16. FF FF FD inside instruction
and parameters is stuffed to FF FF FD FD, except in the answer to a fast sync read, which several servos write together.
Source: ROBOTIS e-manual, "DYNAMIXEL Protocol 2.0".
"""

import dataclasses
import enum
from collections.abc import Mapping, Sequence

HEADER = b"\xff\xff\xfd\x00"
STUFFED, UNSTUFFED = b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"
MAX_ID = 0xFC
BROADCAST_ID = 0xFE
EMPTY_STATUS_SIZE = 11
MAX_LENGTH = 1024
"""Longer packets are taken for rubbish by default."""

ALERT_BIT = 0x80
ERROR_MEANINGS = {
    0x01: "it failed to process the instruction",
    0x02: "it does not know the instruction",
    0x03: "it received the instruction garbled",
    0x04: "the value is out of the register's range",
    0x05: "the data is shorter than the register",
    0x06: "the value is beyond a limit set in the servo",
    0x07: "the register cannot be accessed so (read-only, undefined, or EEPROM while torque is on)",
}
GARBLED_INSTRUCTION = 0x03


class Code(enum.IntEnum):
    """Instruction codes."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REBOOT = 0x08
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x18005 if crc & 0x8000 else 0)
        table.append(crc)
    return tuple(table)


_CRC_TABLE = _crc_table()


def crc16(data: bytes, crc: int = 0) -> int:
    """CRC-16 with polynomial 0x8005 over `data`, going on from `crc` (e-manual, "CRC Calculation")."""
    table = _CRC_TABLE
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc


@dataclasses.dataclass(frozen=True, slots=True)
class Instruction:
    """What a controller sends: `code` to servo `id`, or to all with BROADCAST_ID."""

    id: int
    code: int
    parameters: bytes = b""

    def to_bytes(self) -> bytes:
        """The packet on the wire."""
        body = (bytes((self.code,)) + self.parameters).replace(UNSTUFFED, STUFFED)
        packet = HEADER + bytes((self.id,)) + (len(body) + 2).to_bytes(2, "little") + body
        return packet + crc16(packet).to_bytes(2, "little")


@dataclasses.dataclass(frozen=True, slots=True)
class StatusPacket:
    """What one servo answers: `error` is 0 or a key of ERROR_MEANINGS; `alert` says that its hardware reports an error."""

    id: int
    error: int
    alert: bool
    parameters: bytes = b""


@dataclasses.dataclass(frozen=True, slots=True)
class FastStatusPacket:
    """The one answer that several servos give to a fast sync read, as it came; `split_fast_status` takes it apart."""

    raw: bytes


@dataclasses.dataclass(frozen=True, slots=True)
class Dropped:
    """Bytes that belong to no packet, and why the parser thinks so."""

    data: bytes
    reason: str


Packet = Instruction | StatusPacket | FastStatusPacket | Dropped


class PacketParser:
    """Takes bytes in whatever pieces they come, returns the packets they complete and the rubbish between them.

    Nothing is lost in silence: every byte received ends in a packet, in `Dropped`, or waits for the rest of its packet.
    """

    def __init__(self, max_length: int = MAX_LENGTH) -> None:
        """Start with nothing received. A length field above `max_length` is rubbish: it would only hold up what is behind it."""
        self._buffer = bytearray()
        self._max_length = max_length

    def receive(self, data: bytes) -> list[Packet]:
        """Packets completed by `data`, in order."""
        self._buffer += data
        packets: list[Packet] = []
        while (packet := self._next()) is not None:
            packets.append(packet)
        return packets

    def give_up_waiting(self) -> list[Packet]:
        """No more bytes will come: the packet waited for was none, but others may hide behind its header."""
        packets: list[Packet] = []
        while self._buffer:
            packets.append(self._drop(min(len(self._buffer), len(HEADER)), "incomplete packet"))
            packets += self.receive(b"")
        return packets

    def _next(self) -> Packet | None:
        buffer = self._buffer
        start = buffer.find(HEADER)
        if start != 0:
            rubbish = start if start > 0 else len(buffer) - _possible_header_at_end(buffer)
            return self._drop(rubbish, "no header") if rubbish else None
        if len(buffer) < 7:
            return None
        length = int.from_bytes(buffer[5:7], "little")
        if (buffer[4] > MAX_ID and buffer[4] != BROADCAST_ID) or not 3 <= length <= self._max_length:
            return self._drop(len(HEADER), "impossible id or length")
        return self._complete(7 + length) if len(buffer) >= 7 + length else None

    def _complete(self, size: int) -> Packet:
        raw = bytes(self._buffer[:size])
        if crc16(raw[:-2]) != int.from_bytes(raw[-2:], "little"):
            return self._drop(len(HEADER), "wrong CRC")
        if raw[7] == Code.STATUS and size < EMPTY_STATUS_SIZE:
            return self._drop(len(HEADER), "status packet without error byte")
        del self._buffer[:size]
        return _packet(raw)

    def _drop(self, count: int, reason: str) -> Dropped:
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        return Dropped(data, reason)


def _packet(raw: bytes) -> Packet:
    if raw[7] != Code.STATUS:
        return Instruction(raw[4], raw[7], raw[8:-2].replace(STUFFED, UNSTUFFED))
    if raw[4] == BROADCAST_ID:
        return FastStatusPacket(raw)
    error = raw[8]
    return StatusPacket(
        raw[4], error & ~ALERT_BIT, bool(error & ALERT_BIT), raw[9:-2].replace(STUFFED, UNSTUFFED)
    )


def _possible_header_at_end(buffer: bytes | bytearray) -> int:
    return next((n for n in range(min(3, len(buffer)), 0, -1) if buffer.endswith(HEADER[:n])), 0)


def split_fast_status(raw: bytes, size: int) -> list[StatusPacket]:
    """The servos' answers in the packet that answers a fast sync read of `size` bytes; a part cut short is left out."""
    answers = []
    for part in range(8, len(raw) - size - 3, size + 4):
        error, servo = raw[part], raw[part + 1]
        answers.append(
            StatusPacket(servo, error & ~ALERT_BIT, bool(error & ALERT_BIT), raw[part + 2 : part + 2 + size])
        )
    return answers


def salvage_fast_status(received: bytes, size: int) -> bytes:
    """What is whole of a fast sync read's answer that was cut short or garbled, to be split like an undamaged one.

    Each servo closes its part with the CRC of everything before it, so the parts ahead of the damage are still good.
    """
    start = max(0, received.find(HEADER + bytes((BROADCAST_ID,))))
    crc, whole = 0, start
    end = start + 10 + size
    while end + 2 <= len(received):
        crc = crc16(received[whole:end], crc)
        if crc != int.from_bytes(received[end : end + 2], "little"):
            break
        whole, end = end, end + size + 4
    return received[start : whole + 2] if whole > start else b""


def ping(servo: int) -> Instruction:
    """Ask for model number and firmware version."""
    return Instruction(servo, Code.PING)


def reboot(servo: int) -> Instruction:
    """Restart the servo: RAM, hardware error and turns counted so far are forgotten."""
    return Instruction(servo, Code.REBOOT)


def read(servo: int, address: int, size: int) -> Instruction:
    """Ask for `size` bytes from `address`."""
    return Instruction(servo, Code.READ, _words(address, size))


def write(servo: int, address: int, data: bytes) -> Instruction:
    """Write `data` from `address`."""
    return Instruction(servo, Code.WRITE, _words(address) + data)


def sync_read(servos: Sequence[int], address: int, size: int) -> Instruction:
    """Ask several servos for the same bytes; each answers with a packet of its own."""
    return Instruction(BROADCAST_ID, Code.SYNC_READ, _words(address, size) + bytes(servos))


def fast_sync_read(servos: Sequence[int], address: int, size: int) -> Instruction:
    """Ask several servos for the same bytes; all answer in one packet. Firmware 45 (X330: 46) or newer."""
    return Instruction(BROADCAST_ID, Code.FAST_SYNC_READ, _words(address, size) + bytes(servos))


def sync_write(address: int, data: Mapping[int, bytes]) -> Instruction:
    """Write to several servos at once, to each its own bytes, all of one size; nobody answers."""
    size = len(next(iter(data.values())))
    parts = b"".join(bytes((servo,)) + values for servo, values in data.items())
    return Instruction(BROADCAST_ID, Code.SYNC_WRITE, _words(address, size) + parts)


def _words(*values: int) -> bytes:
    return b"".join(value.to_bytes(2, "little") for value in values)
