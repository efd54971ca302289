"""A part of a JPEG without decoding the rest, where the camera put restart markers into it.

Between two restart markers a baseline JPEG can be read by itself (ITU-T T.81, sections B.2.1 and E.1.4): the stretches
that cover the wanted part are copied, byte for byte, behind a header with a smaller size. The luma that a decoder makes
of it is exactly that part of the whole picture's. A JPEG without restart markers has to be decoded whole.
"""

from dataclasses import dataclass

import numpy as np

START_OF_FRAME, START_OF_SCAN, RESTART_INTERVAL, END_OF_IMAGE = 0xC0, 0xDA, 0xDD, b"\xff\xd9"
BLOCK_PX = 8

Box = tuple[int, int, int, int]
"""Left, top, right and bottom in px; right and bottom are not part of it."""


@dataclass(frozen=True)
class _Header:
    """What a baseline header says: where the size stands, the size, a minimal unit's size, the restart interval, the scan."""

    size_at: int
    width: int
    height: int
    unit_width: int
    unit_height: int
    interval: int
    scan_at: int


def crop(data: bytes, size_px: tuple[int, int], box: Box) -> tuple[bytes, Box] | None:
    """A JPEG of the stretches around `box` and the part that it shows, or None when `data` cannot be taken apart.

    A picture of another size than `size_px` (width, height) is not taken apart either.
    """
    header = _read_header(data)
    if header is None or header.interval == 0 or (header.width, header.height) != size_px:
        return None
    units_across = -(-header.width // header.unit_width)
    rows = -(-header.height // header.unit_height)
    if units_across % header.interval:
        return None
    columns = units_across // header.interval
    end = data.rfind(END_OF_IMAGE)
    codes = np.frombuffer(data, np.uint8)[header.scan_at : end]
    markers = header.scan_at + np.flatnonzero((codes[:-1] == 0xFF) & (codes[1:] & 0xF8 == 0xD0))
    if len(markers) != rows * columns - 1:
        return None
    starts = [header.scan_at, *(markers + 2).tolist()]
    ends = [*markers.tolist(), end]

    wide = header.interval * header.unit_width
    first_column, last_column = max(box[0], 0) // wide, min((box[2] - 1) // wide, columns - 1)
    first_row, last_row = (
        max(box[1], 0) // header.unit_height,
        min((box[3] - 1) // header.unit_height, rows - 1),
    )
    if last_column < first_column or last_row < first_row:
        return None
    shown = (
        first_column * wide,
        first_row * header.unit_height,
        min((last_column + 1) * wide, header.width),
        min((last_row + 1) * header.unit_height, header.height),
    )
    stretches = [
        row * columns + column
        for row in range(first_row, last_row + 1)
        for column in range(first_column, last_column + 1)
    ]
    parts = [_resized(data[: header.scan_at], header, shown[2] - shown[0], shown[3] - shown[1])]
    for number, stretch in enumerate(stretches):
        if number:
            parts.append(bytes((0xFF, 0xD0 + (number - 1) % 8)))
        parts.append(data[starts[stretch] : ends[stretch]])
    return b"".join((*parts, END_OF_IMAGE)), shown


def _read_header(data: bytes) -> _Header | None:
    at, size_at, width, height, unit, interval = 2, 0, 0, 0, (0, 0), 0
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if marker == START_OF_FRAME:
            size_at = at + 5
            height, width = (int.from_bytes(data[size_at + i : size_at + i + 2], "big") for i in (0, 2))
            components = int.from_bytes(data[at + 9 : at + 10])
            factors = data[at + 11 : at + 11 + 3 * components : 3]
            if not factors:
                return None
            most = max(factor >> 4 for factor in factors), max(factor & 15 for factor in factors)
            unit = most if len(factors) > 1 else (1, 1)
        elif marker == RESTART_INTERVAL:
            interval = int.from_bytes(data[at + 4 : at + 6], "big")
        elif marker == START_OF_SCAN:
            found = _Header(
                size_at, width, height, BLOCK_PX * unit[0], BLOCK_PX * unit[1], interval, at + 2 + length
            )
            return found if size_at and min(found.unit_width, found.unit_height, width, height) > 0 else None
        at += 2 + length
    return None


def _resized(header: bytes, read: _Header, width: int, height: int) -> bytes:
    size = height.to_bytes(2, "big") + width.to_bytes(2, "big")
    return header[: read.size_at] + size + header[read.size_at + 4 :]
