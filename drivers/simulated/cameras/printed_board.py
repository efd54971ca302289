"""The printed board as a bitmap: what the simulated person holds before the cameras."""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Pixels
from drivers.simulated.cameras.errors import SimulatedBoardError
from messaging.board import BoardSettings

REFERENCE_BOARD = BoardSettings()
"""The reference bench's."""

_PAPER, _INK = 205, 18
_SQUARE_PX = 120  # markers of 4 to 7 modules, of half a square and more, come out in nearly whole pixels
_MARGIN_SQUARES = 0.5


@dataclass(frozen=True)
class PrintedBoard:
    """A sheet of paper with the board's squares, and a margin around them."""

    levels: Pixels
    """(rows, columns) in even light."""
    pixels_from_board: Array
    """(3, 3) from the board's (x mm, y mm, 1) to (column, row, 1) of `levels`; whole numbers are pixel centres."""
    outline_mm: Array
    """(n, 2) around the edge of the paper."""
    squares_mm: Array
    """(2,) width and height of all squares together."""


def printed_board(board: BoardSettings) -> PrintedBoard:
    """The board of a bench file; raises SimulatedBoardError for one that OpenCV cannot draw."""
    columns, rows = board.squares
    pattern = _charuco(board) if board.kind == "charuco" else _chessboard(columns, rows)
    margin_px = int(_MARGIN_SQUARES * _SQUARE_PX)
    white = np.pad(pattern, margin_px, constant_values=255)
    scale = _SQUARE_PX / board.square_mm
    squares_mm = np.array([columns, rows]) * board.square_mm
    return PrintedBoard(
        levels=np.where(white > 127, _PAPER, _INK).astype(np.uint8),
        pixels_from_board=np.array(
            [[scale, 0, margin_px - 0.5], [0, scale, margin_px - 0.5], [0, 0, 1]], dtype=np.float64
        ),
        outline_mm=_outline(squares_mm, _MARGIN_SQUARES * board.square_mm),
        squares_mm=squares_mm,
    )


def _charuco(board: BoardSettings) -> Pixels:
    if not hasattr(cv2.aruco, board.dictionary):
        raise SimulatedBoardError(
            f"board.dictionary {board.dictionary}: OpenCV does not know it; one that it knows is DICT_4X4_50"
        )
    columns, rows = board.squares
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    needed, known = columns * rows // 2, len(dictionary.bytesList)
    if needed > known:
        raise SimulatedBoardError(
            f"board.squares {columns} x {rows} need {needed} markers; {board.dictionary} has {known}"
        )
    charuco = cv2.aruco.CharucoBoard(board.squares, board.square_mm, board.marker_mm, dictionary)
    charuco.setLegacyPattern(board.legacy_pattern)
    return np.asarray(charuco.generateImage((columns * _SQUARE_PX, rows * _SQUARE_PX)), dtype=np.uint8)


def _chessboard(columns: int, rows: int) -> Pixels:
    white = np.indices((rows, columns)).sum(axis=0) % 2
    picture: Pixels = np.kron(255 * white, np.ones((_SQUARE_PX, _SQUARE_PX))).astype(np.uint8)
    return picture


def _outline(squares_mm: Array, margin_mm: float) -> Array:
    along = np.linspace(0, 1, 9)[:-1]
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    around = np.concatenate([a + along[:, None] * (b - a) for a, b in pairwise(corners)])
    outline: Array = around * (squares_mm + 2 * margin_mm) - margin_mm
    return outline
