"""JPEG pictures of which only a window is encoded anew.

A baseline JPEG with restart markers (ITU T.81, F.1.1.5) is a row of stretches of code that know nothing of one another:
a stretch of one picture may take the place of the same stretch of another, if both were encoded alike. Markers between
stretches count modulo 8.
"""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.simulated.cameras.arrays import Pixels
from drivers.simulated.cameras.canvas import Window

_UNIT_PX = 16  # a coded unit, with colours at half resolution both ways, as webcams code them
_UNITS_PER_STRETCH = 5
_FIRST_RESTART = 0xD0
_END_OF_PICTURE = b"\xff\xd9"


@dataclass(frozen=True)
class Raster:
    """How a picture is cut: rows of coded units, each in `columns` stretches."""

    width_px: int
    height_px: int
    columns: int
    rows: int
    column_width_px: int

    @classmethod
    def of(cls, width_px: int, height_px: int) -> Self:
        """Short stretches where they fill the width exactly, else one a row."""
        units = -(-width_px // _UNIT_PX)
        fits = width_px % (_UNIT_PX * _UNITS_PER_STRETCH) == 0
        columns = units // _UNITS_PER_STRETCH if fits else 1
        return cls(width_px, height_px, columns, -(-height_px // _UNIT_PX), units // columns * _UNIT_PX)

    def widen(self, window: Window) -> Window:
        """The smallest window of whole stretches that holds what of this one lies within the picture; at least one stretch."""
        left, right = _whole(window.left, window.right, self.column_width_px, self.width_px)
        top, bottom = _whole(window.top, window.bottom, _UNIT_PX, self.height_px)
        return Window(left, top, right, bottom)

    def encode(self, pixels: Pixels, quality: int) -> "Stretches":
        """The code of a picture, or of a window made of whole stretches."""
        parameters = [
            cv2.IMWRITE_JPEG_QUALITY,
            quality,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
            cv2.IMWRITE_JPEG_RST_INTERVAL,
            self.column_width_px // _UNIT_PX,
        ]
        return Stretches.of(cv2.imencode(".jpg", pixels, parameters)[1])


@dataclass(frozen=True)
class Stretches:
    """The bytes of a JPEG, and where its stretches lie."""

    code: bytes
    start: list[int]
    """Where each stretch begins; and, last, where one more would: its marker's end."""

    @classmethod
    def of(cls, code: NDArray[np.uint8]) -> Self:
        """Find the stretches. Within code a byte FF is never followed by a marker's number unless it is one."""
        scan = _scan_start(code)
        marks = scan + np.flatnonzero(code[scan:-1] == 0xFF)
        marks = marks[(code[marks + 1] & 0xF8) == _FIRST_RESTART]
        return cls(code.tobytes(), [scan, *(marks + 2).tolist(), len(code)])

    def renumbered(self, numbers: NDArray[np.intp]) -> bytes:
        """The bytes with a restart marker after every stretch, the last one too, that says its number (n,)."""
        code = np.frombuffer(self.code, np.uint8).copy()
        marks = np.array(self.start[1:])
        code[marks - 2] = 0xFF
        code[marks - 1] = _FIRST_RESTART + numbers % 8
        return code.tobytes()


def splice(picture: Stretches, patch: Stretches, window: Window, raster: Raster) -> bytes:
    """The JPEG `picture` with `patch` in its `window`."""
    first_column, end_column = (
        window.left // raster.column_width_px,
        -(-window.right // raster.column_width_px),
    )
    first_row, end_row = window.top // _UNIT_PX, -(-window.bottom // _UNIT_PX)
    rows, columns = np.arange(first_row, end_row), np.arange(first_column, end_column)
    first = rows * raster.columns + first_column
    code = patch.renumbered((rows[:, None] * raster.columns + columns).ravel())
    ends = (first + len(columns)).tolist()
    pieces = []
    kept = patched = 0
    for begin, end in zip(first.tolist(), ends, strict=True):
        pieces.append(picture.code[kept : picture.start[begin]])
        pieces.append(code[patch.start[patched] : patch.start[patched + len(columns)]])
        patched += len(columns)
        kept = picture.start[end]
    if ends[-1] == raster.rows * raster.columns:
        pieces[-1] = pieces[-1][:-2] + _END_OF_PICTURE
    pieces.append(picture.code[kept:])
    return b"".join(pieces)


def _whole(begin: int, end: int, unit: int, size: int) -> tuple[int, int]:
    """From a multiple of `unit` to another, or to `size`: around `begin` to `end`, one unit at least, within 0 to `size`."""
    first = min(max(begin, 0), size - 1) // unit * unit
    last = -(-max(min(end, size), first + 1) // unit) * unit
    return first, min(last, size)


def _scan_start(code: NDArray[np.uint8]) -> int:
    """Where the header ends: segments follow one another, each with its length, up to the start of the scan."""
    position = 2
    while True:
        marker, length = code[position + 1], int(code[position + 2]) << 8 | int(code[position + 3])
        position += 2 + length
        if marker == 0xDA:
            return position
