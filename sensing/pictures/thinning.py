"""A mask thinned to lines one pixel wide: Guo and Hall, "Parallel thinning with two-subiteration algorithms", CACM 32 (1989).

Whether a pixel goes depends on its eight neighbours alone: they are coded as one number, and a table says the rest.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from sensing.pictures.segmentation import Mask

AROUND = np.array([[128, 1, 2], [64, 0, 4], [32, 16, 8]], dtype=np.float32)
"""The bit of each neighbour, clockwise from the one above."""


def _table(odd: bool) -> NDArray[np.uint8]:
    """1 for every code of neighbours with which a pixel stays, 0 where it goes, in odd or even rounds."""
    code = np.arange(256)
    n, ne, e, se, s, sw, w, nw = ((code >> bit) & 1 == 1 for bit in range(8))
    parts = sum(~a & (b | c) for a, b, c in ((n, ne, e), (e, se, s), (s, sw, w), (w, nw, n))).astype(int)
    pairs = (nw | n) * 1 + (ne | e) + (se | s) + (sw | w)
    turned = (n | ne) * 1 + (e | se) + (s | sw) + (w | nw)
    fewest = np.minimum(pairs, turned)
    kept_side = (n | ne | ~se) & e if odd else (s | sw | ~nw) & w
    goes = (parts == 1) & (fewest >= 2) & (fewest <= 3) & ~kept_side
    return np.where(goes, np.uint8(0), np.uint8(1))


TABLES = _table(odd=False), _table(odd=True)


def thinned(mask: Mask) -> NDArray[np.bool_]:
    """The lines (h, w) left of a mask (h, w) whose outermost pixels are empty."""
    line = (mask > 0).astype(np.uint8)
    left = -1
    while left != (left := int(np.count_nonzero(line))):
        for table in TABLES:
            code = cv2.filter2D(line, cv2.CV_8U, AROUND, borderType=cv2.BORDER_CONSTANT)
            line = np.asarray(cv2.bitwise_and(line, cv2.LUT(code, table)), dtype=np.uint8)
    return line > 0
