"""The printed board: where its corners are, and finding them in a picture."""

from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.charuco import Charuco
from calibration.chessboard import Chessboard
from calibration.corners import Array, Corners, Missing, Picture
from calibration.planes import homography, mapped, sides_at
from calibration.saddles import refine
from messaging.board import BoardSettings

FEWEST_CORNERS = 8
"""Four corners give a pose and tell nothing about the camera; twice as many do, and outvote a wrong one."""
ARM_SIDES = 0.45
"""The next corner, with a blur of its own, is one side away."""
MOST_WARP_SIDES = 0.12
"""A lens bends the board by a few hundredths of a side; corners of another layout are off by more."""


class Finder(Protocol):
    """A way to find the corners of one kind of board; `clear` is how far from an edge nothing else is printed, in sides."""

    clear: float

    def find(self, grey: Picture) -> tuple[NDArray[np.int64], Array] | Missing:
        """Ids (n,) and pixels (n, 2) to start from, or the reason why there are none."""


def corners_mm(settings: BoardSettings) -> Array:
    """All inner corners (n, 3) of a board that is flat and true, along its rows."""
    columns, rows = settings.squares
    right, down = np.meshgrid(np.arange(1.0, columns), np.arange(1.0, rows))
    flat = np.column_stack([right.ravel(), down.ravel(), np.zeros(right.size)])
    return np.asarray(settings.square_mm * flat)


class Board:
    """A ChArUco board or a plain chessboard, in OpenCV's board frame: origin at the top left corner of the squares, z into it.

    `points_mm` (n, 3) are all inner corners in the order of their ids, which count along the rows; there are `columns` times
    `rows` of them. Raises BoardError for an unknown dictionary, for one with fewer markers than the board needs, and for a
    chessboard that looks the same upside down: two cameras could then not agree on which corner is which.
    """

    def __init__(self, settings: BoardSettings) -> None:
        self.settings = settings
        self.columns, self.rows = settings.squares[0] - 1, settings.squares[1] - 1
        self.points_mm = corners_mm(settings)
        self._finder: Finder = Charuco(settings) if settings.kind == "charuco" else Chessboard(settings)

    def find(self, picture: Picture) -> Corners | Missing:
        """The board's corners in a picture, as exact as its edges allow, or the reason why they are not there."""
        grey = np.asarray(
            picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8
        )
        found = self._finder.find(grey)
        if isinstance(found, Missing):
            return found
        order = np.argsort(found[0])
        ids, px = found[0][order], found[1][order]
        if len(ids) < FEWEST_CORNERS:
            return Missing(
                f"only {len(ids)} of {len(self.points_mm)} corners are in sight, {FEWEST_CORNERS} are needed"
            )
        flat = np.asarray(self.points_mm[ids, :2] / self.settings.square_mm, np.float64)
        picture_from_board = homography(flat, px)
        if picture_from_board is None:
            return Missing(f"the {len(ids)} corners in sight lie in one line")
        sides_px = sides_at(picture_from_board, flat)
        warp = np.linalg.norm(mapped(picture_from_board, flat) - px, axis=1)
        if np.median(warp / np.linalg.norm(sides_px, axis=2).min(axis=1)) > MOST_WARP_SIDES:
            columns, rows = self.settings.squares
            return Missing(
                f"another layout: the corners do not lie as on a board of {columns} x {rows} squares"
            )
        fitted = refine(grey, px, sides_px, ARM_SIDES, self._finder.clear)
        left = np.flatnonzero(fitted.sound)
        if len(left) < FEWEST_CORNERS or homography(flat[left], fitted.px[left]) is None:
            return Missing("too blurred or too dark: corners show hardly any contrast")
        return Corners(ids, fitted.px, fitted.blur_px).only(fitted.sound)
