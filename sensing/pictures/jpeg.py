"""What a JPEG says of itself before it is decoded (ITU-T T.81, annex B), and where its restart markers lie."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle

import numpy as np
from numpy.typing import NDArray

from sensing.errors import UnreadableImageError

START, END = b"\xff\xd8", b"\xff\xd9"
START_OF_SCAN, RESTART_INTERVAL, FIRST_RESTART = 0xDA, 0xDD, 0xD0
BASELINE, EXTENDED, PROGRESSIVE = 0xC0, 0xC1, 0xC2
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers that begin a frame; the three left out are tables and a reserved one."""
RESTARTS = tuple(bytes((0xFF, FIRST_RESTART + number)) for number in range(8))
BLOCK_PX = 8
LEVELS_BITS = 8

Places = NDArray[np.intp]


@dataclass(frozen=True)
class Jpeg:
    """A JPEG up to its first scan. `unit_px` (width, height) is its minimal coded unit's size, `interval` the units between
    restart markers (0: there are none), `simple` whether it is baseline and all of it is in one scan.
    """

    data: bytes
    width: int
    height: int
    unit_px: tuple[int, int]
    grey: bool
    simple: bool
    interval: int
    size_at: int
    scan_at: int

    @classmethod
    def read(cls, camera: str, data: bytes) -> "Jpeg":
        """The JPEG in these bytes; raises UnreadableImageError when it is cut off, or of a kind that no camera makes."""
        jpeg = _header(camera, data)
        if data.rfind(END) < jpeg.scan_at:
            raise UnreadableImageError(camera, f"the JPEG of {len(data)} bytes is cut off before its end")
        if jpeg.simple and (found := len(jpeg.stretches[0]) - 1) != jpeg.restarts:
            raise UnreadableImageError(
                camera,
                f"the JPEG has {found} restart markers in their order where its header announces "
                f"{jpeg.restarts}; a part of it is missing",
            )
        return jpeg

    @property
    def units_across(self) -> int:
        """Minimal units in a row."""
        return -(-self.width // self.unit_px[0])

    @property
    def rows(self) -> int:
        """Rows of minimal units."""
        return -(-self.height // self.unit_px[1])

    @property
    def restarts(self) -> int:
        """How many restart markers there have to be."""
        return (self.units_across * self.rows - 1) // self.interval if self.interval else 0

    @cached_property
    def stretches(self) -> tuple[Places, Places]:
        """Where the scan's data begin and end (k,) between restart markers, up to the first marker out of order."""
        if not self.interval:
            return np.array([self.scan_at]), np.array([self.data.rfind(END)])
        codes = np.frombuffer(self.data, np.uint8)
        at = self.scan_at + np.flatnonzero(codes[self.scan_at : -1] == 0xFF)
        kinds = codes[at + 1]
        # 0 stands for a 0xFF among the data, and any number of 0xFF may come before a marker
        markers = (kinds != 0) & (kinds != 0xFF)
        at, kinds = at[markers], kinds[markers]
        in_order = kinds == FIRST_RESTART + np.arange(len(kinds)) % 8
        count = len(kinds) if in_order.all() else int(in_order.argmin())
        ends = at[: count + 1] if count < len(at) else np.append(at, len(codes))
        return np.insert(ends[:-1] + 2, 0, self.scan_at), ends

    def parts(self, numbers: Sequence[int]) -> list[bytes]:
        """The data of these stretches."""
        begins, ends = (places[list(numbers)].tolist() for places in self.stretches)
        return [self.data[begin:end] for begin, end in zip(begins, ends, strict=True)]

    def resized(self, width: int, height: int, stretches: list[bytes]) -> "Jpeg":
        """A JPEG of this header, another size, and these stretches with restart markers between."""
        size = height.to_bytes(2, "big") + width.to_bytes(2, "big")
        parts = [self.data[: self.size_at], size, self.data[self.size_at + 4 : self.scan_at], stretches[0]]
        for marker, stretch in zip(cycle(RESTARTS), stretches[1:], strict=False):
            parts += marker, stretch
        return replace(self, data=b"".join((*parts, END)), width=width, height=height)


def _header(camera: str, data: bytes) -> Jpeg:
    at, size_at, interval, kind, factors = len(START), 0, 0, 0, b""
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if marker == 0xFF:
            at += 1
            continue
        if marker in FRAMES:
            kind, size_at = marker, at + 5
            factors = _sampling(camera, kind, data[at + 4 : at + 2 + length])
        elif marker == RESTART_INTERVAL:
            interval = int.from_bytes(data[at + 4 : at + 6], "big")
        elif marker == START_OF_SCAN and factors and at + 2 + length <= len(data):
            most = max(factor >> 4 for factor in factors), max(factor & 15 for factor in factors)
            unit = most if len(factors) > 1 else (1, 1)
            height, width = (int.from_bytes(data[size_at + i : size_at + i + 2], "big") for i in (0, 2))
            if min(*unit, width, height) > 0:
                return Jpeg(
                    data=data,
                    width=width,
                    height=height,
                    unit_px=(BLOCK_PX * unit[0], BLOCK_PX * unit[1]),
                    grey=len(factors) == 1,
                    simple=kind in (BASELINE, EXTENDED) and data[at + 4] == len(factors),
                    interval=interval,
                    size_at=size_at,
                    scan_at=at + 2 + length,
                )
            break
        at += 2 + length
    raise UnreadableImageError(camera, f"the JPEG of {len(data)} bytes has no header that can be read")


def _sampling(camera: str, kind: int, frame: bytes) -> bytes:
    """The components' sampling factors in a frame header."""
    if kind not in (BASELINE, EXTENDED, PROGRESSIVE):
        raise UnreadableImageError(
            camera,
            f"the JPEG is of kind SOF{kind - BASELINE} (lossless, hierarchical or arithmetic-coded); "
            "allowed are baseline and progressive ones with Huffman codes (SOF0, SOF1, SOF2)",
        )
    if frame[:1] != bytes((LEVELS_BITS,)):
        raise UnreadableImageError(
            camera, f"the JPEG has {frame[0] if frame else 0} bits a sample; allowed are {LEVELS_BITS}"
        )
    count = int.from_bytes(frame[5:6], "big")
    if count not in (1, 3):
        raise UnreadableImageError(
            camera, f"the JPEG has {count} components; allowed are 1 (grey) and 3 (colour)"
        )
    factors = frame[7 : 7 + 3 * count : 3]
    return factors if len(factors) == count else b""
