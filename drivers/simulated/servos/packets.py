"""Protocol 2.0 as a servo speaks it. Written apart from the real driver's, so that no mistake can hide on both sides."""

import dataclasses
from collections.abc import Iterator

_START = bytes((0xFF, 0xFF, 0xFD, 0x00))
_LONGEST = 2048
LENGTH_END = 0xFFFF
FAST_PART_EXTRA = 4
"""Error, id and CRC around each servo's data in a common answer."""


def checksum(data: bytes | bytearray) -> int:
    """The e-manual's CRC: x^16 + x^15 + x^2 + 1, most significant bit first, starting from 0."""
    remainder = 0
    for byte in data:
        remainder ^= byte << 8
        for _ in range(8):
            remainder = (remainder << 1 ^ 0x8005 if remainder >> 15 else remainder << 1) & 0xFFFF
    return remainder


_REMAINDER = [checksum(bytes((value,))) for value in range(256)]


def append_crc(data: bytes) -> bytes:
    """`data` with its CRC behind it."""
    remainder = 0
    for byte in data:
        remainder = (remainder << 8 & 0xFFFF) ^ _REMAINDER[remainder >> 8 ^ byte]
    return data + bytes((remainder & 0xFF, remainder >> 8))


def status(servo: int, error: int, parameters: bytes = b"") -> bytes:
    """A status packet."""
    stuffed = bytearray()
    for byte in (0x55, error, *parameters):
        stuffed.append(byte)
        if stuffed[-3:] == b"\xff\xff\xfd":
            stuffed.append(0xFD)
    return append_crc(_START + bytes((servo, (len(stuffed) + 2) & 0xFF, (len(stuffed) + 2) >> 8)) + stuffed)


def fast_status_start(count: int, size: int) -> bytes:
    """What the first of `count` servos puts before its part of a common answer, `size` bytes from each."""
    length = 1 + count * (size + FAST_PART_EXTRA)
    return _START + bytes((0xFE, length & 0xFF, length >> 8, 0x55))


@dataclasses.dataclass(frozen=True, slots=True)
class Received:
    """An instruction packet as it arrived; `intact` says whether its CRC is right."""

    servo: int
    code: int
    parameters: bytes
    intact: bool


class InstructionReader:
    """Finds instruction packets in a stream of bytes."""

    def __init__(self) -> None:
        """Start with an empty line."""
        self._pending = b""

    def feed(self, data: bytes) -> Iterator[Received]:
        """The packets completed by `data`."""
        self._pending += data
        while (packet := self._take()) is not None:
            yield packet

    def _take(self) -> Received | None:
        while (at := self._pending.find(_START)) >= 0:
            waiting = self._pending[at:]
            self._pending = waiting
            if len(waiting) < 7:
                return None
            length = waiting[5] | waiting[6] << 8
            if not 3 <= length <= _LONGEST:
                self._pending = waiting[4:]
                continue
            if len(waiting) < 7 + length:
                return None
            whole = waiting[: 7 + length]
            intact = append_crc(whole[:-2]) == whole
            self._pending = waiting[7 + length :] if intact else waiting[4:]
            if whole[7] != 0x55:
                return Received(whole[4], whole[7], _unstuff(whole[8:-2]), intact)
        self._pending = self._pending[-3:]
        return None


def _unstuff(parameters: bytes) -> bytes:
    return parameters.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
