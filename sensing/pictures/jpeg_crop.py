"""A part of a JPEG without decoding the rest, where the camera put restart markers into it.

Between two restart markers a baseline JPEG can be read by itself (ITU-T T.81, sections B.2.1 and E.1.4): the stretches
that cover the wanted part are copied, byte for byte, behind a header with a smaller size. The luma that a decoder makes
of it is exactly that part of the whole picture's. A JPEG without restart markers has to be decoded whole.
"""

from sensing.pictures.jpeg import Jpeg

Box = tuple[int, int, int, int]
"""Left, top, right and bottom in px; right and bottom are not part of it."""


def crop(jpeg: Jpeg, box: Box) -> tuple[Jpeg, Box] | None:
    """A JPEG of the stretches around `box` and the part that it shows, or None when it cannot be taken apart."""
    if not jpeg.simple or not jpeg.interval or jpeg.units_across % jpeg.interval:
        return None
    columns = jpeg.units_across // jpeg.interval
    wide, high = jpeg.interval * jpeg.unit_px[0], jpeg.unit_px[1]
    first_column, last_column = max(box[0], 0) // wide, min((box[2] - 1) // wide, columns - 1)
    first_row, last_row = max(box[1], 0) // high, min((box[3] - 1) // high, jpeg.rows - 1)
    if last_column < first_column or last_row < first_row:
        return None
    left, top = first_column * wide, first_row * high
    right, bottom = min((last_column + 1) * wide, jpeg.width), min((last_row + 1) * high, jpeg.height)
    covering = [
        row * columns + column
        for row in range(first_row, last_row + 1)
        for column in range(first_column, last_column + 1)
    ]
    return jpeg.resized(right - left, bottom - top, jpeg.parts(covering)), (left, top, right, bottom)
