"""Whether a JPEG's data reach to its end. Decoders fill what is missing with mid-grey, and say nothing.

That grey is exact, so the unit before each restart marker and at the end is looked at, which costs next to nothing. Where
one is that grey, the data are made longer and decoded again: only where some were missing, that changes the picture.
Progressive JPEGs, which hide missing data and which no camera sends, are always decoded again.

Long runs of zeros, as a buffer holds that was not filled, may last beyond the end; then the picture is asked for more
rows than it has, and data that go on show in these. What cannot be seen: less than a unit that is missing, more data
between two restart markers than there were, and other levels in the same number of units.
"""

from collections.abc import Callable

import numpy as np

from sensing.pictures.jpeg import END, START_OF_SCAN, Jpeg
from sensing.pictures.light import Image

MISSING_LEVEL = 128
UNFILLED = bytes(64)
LARGEST_PX = 65500
"""No JPEG decoder takes more."""


def data_missing(jpeg: Jpeg, picture: Image, factor: int, decode: Callable[[bytes], Image | None]) -> bool:
    """Whether a part of this `picture`, decoded `factor` times smaller by `decode`, was never in the data."""
    if not jpeg.simple or _blank(jpeg, picture, factor):
        longer = decode(_longer(jpeg))
        return longer is None or not np.array_equal(picture, longer)
    return False


def data_left(jpeg: Jpeg, factor: int, decode: Callable[[bytes], Image | None]) -> bool:
    """Whether zeros stand where data should, and go on when all units are read."""
    taller_px = (jpeg.rows + 2) * jpeg.unit_px[1]
    if jpeg.interval or taller_px > LARGEST_PX or jpeg.data.find(UNFILLED, jpeg.scan_at) < 0:
        return False
    picture = decode(jpeg.resized(jpeg.width, taller_px, jpeg.parts([0])).data)
    # the bits that fill the last byte make one more unit
    return picture is None or bool(
        (picture[(jpeg.rows + 1) * jpeg.unit_px[1] // factor :] != MISSING_LEVEL).any()
    )


def _blank(jpeg: Jpeg, picture: Image, factor: int) -> bool:
    """Whether the last unit of a stretch is as if it was missing."""
    units = jpeg.units_across * jpeg.rows
    last = np.append(np.arange(jpeg.interval, units, jpeg.interval or units), units) - 1
    width, height = (max(px // factor, 1) for px in jpeg.unit_px)
    left, top = last % jpeg.units_across * width, last // jpeg.units_across * height
    middles = picture[
        np.minimum(top + height // 2, picture.shape[0] - 1),
        np.minimum(left + width // 2, picture.shape[1] - 1),
    ]
    grey = (middles.reshape(len(last), -1) == MISSING_LEVEL).all(axis=1)
    return any(
        (
            picture[_inner(y, height, picture.shape[0]), _inner(x, width, picture.shape[1])] == MISSING_LEVEL
        ).all()
        for x, y in zip(left[grey], top[grey], strict=True)
    )


def _inner(start: int, size: int, end: int) -> slice:
    """Without the margin into which the neighbours' colours run."""
    return slice(min(start + size // 4, end - 1), start + size - size // 4)


def _longer(jpeg: Jpeg) -> bytes:
    """With the data of each stretch once more behind them."""
    if jpeg.simple:
        twice = [2 * part for part in jpeg.parts(range(jpeg.restarts + 1))]
        return jpeg.resized(jpeg.width, jpeg.height, twice).data
    last_scan = jpeg.data.rfind(bytes((0xFF, START_OF_SCAN)))
    begin = last_scan + 2 + int.from_bytes(jpeg.data[last_scan + 2 : last_scan + 4], "big")
    end = jpeg.data.rfind(END)
    return jpeg.data[:end] + jpeg.data[begin:]
