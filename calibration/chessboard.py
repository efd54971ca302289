"""Finding a plain chessboard: all of it must be in sight, and its colours say which way is up."""

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array, Missing, Picture
from calibration.errors import BoardError
from messaging.board import BoardSettings

WAYS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY


class Chessboard:
    """The finder of a chessboard whose top left square is black, as OpenCV draws it.

    Turned by half a turn, a board of an even and an odd number of squares has a white square there; one of two even or two
    odd numbers looks the same, and is refused with a BoardError.
    """

    clear = 0.45

    def __init__(self, settings: BoardSettings) -> None:
        columns, rows = settings.squares
        if (columns + rows) % 2 == 0:
            raise BoardError(
                f"board.squares: a chessboard of {columns} x {rows} squares looks the same upside down, "
                f"so cameras cannot agree on its corners; take an even and an odd number, such as "
                f'{columns} x {rows - 1}, or kind = "charuco"'
            )
        self._inner = columns - 1, rows - 1

    def find(self, grey: Picture) -> tuple[NDArray[np.int64], Array] | Missing:
        """Ids (n,) and pixels (n, 2) to start from, or the reason why there are none."""
        found, px = cv2.findChessboardCornersSB(grey, self._inner, flags=WAYS)
        if not found:
            columns, rows = self._inner
            return Missing(f"no chessboard with {columns} x {rows} inner corners is wholly in sight")
        grid = np.reshape(px, (self._inner[1], self._inner[0], 2)).astype(np.float64)
        right, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
        if right[0] * down[1] < right[1] * down[0]:
            grid = grid[:, ::-1]
        if _brightness(grey, grid[:2, :2]) > _brightness(grey, grid[:2, 1:3]):
            grid = grid[::-1, ::-1]
        return np.arange(grid.shape[0] * grid.shape[1]), grid.reshape(-1, 2)


def _brightness(grey: Picture, corners: Array) -> float:
    """Of the middle of the square between four corners (2, 2, 2)."""
    middle = corners.mean(axis=(0, 1))
    return float(cv2.getRectSubPix(grey, (5, 5), (float(middle[0]), float(middle[1]))).mean())
