"""What is black on a board: the very pattern of OpenCV's boards, as rectangles. Pure."""

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.charuco import charuco_board
from messaging.board import BoardSettings

Array = NDArray[np.float64]


def black_rectangles_mm(board: BoardSettings) -> Array:
    """(N, 4) x0, y0, x1, y1 in the board's plane, from its top left corner; none overlaps another."""
    if board.kind == "chessboard":
        return _squares_mm(board, np.zeros((0, 2)))
    charuco = charuco_board(board)
    markers_mm = np.array(charuco.getObjPoints())[:, :, :2]
    dictionary = charuco.getDictionary()
    ids = np.ravel(charuco.getIds())
    cells = [_marker_mm(dictionary, int(id_), corners) for id_, corners in zip(ids, markers_mm, strict=True)]
    return np.vstack([_squares_mm(board, markers_mm.mean(axis=1)), *cells])


def _squares_mm(board: BoardSettings, markers_mm: Array) -> Array:
    """The squares without the middle (N, 2) of a marker; where there are no markers, those of the top left one's colour."""
    columns, rows = board.squares
    white = {tuple(cell) for cell in (markers_mm // board.square_mm).astype(int).tolist()}
    corners = [
        (column, row)
        for row in range(rows)
        for column in range(columns)
        if ((column, row) not in white if white else (column + row) % 2 == 0)
    ]
    return np.array([(x, y, x + 1, y + 1) for x, y in corners]) * board.square_mm


def _marker_mm(dictionary: cv2.aruco.Dictionary, id_: int, corners_mm: Array) -> Array:
    """The black cells of a marker within these corners (4, 2), from the top left one on."""
    cells = dictionary.markerSize + 2
    # OpenCV draws a border of one cell around the bits; at one pixel a cell the picture is the pattern itself
    picture = dictionary.generateImageMarker(id_, cells)
    rows, columns = np.nonzero(picture == 0)
    cell_mm = (corners_mm[2] - corners_mm[0]) / cells
    cells_mm = np.column_stack([columns, rows, columns + 1, rows + 1]) * np.tile(cell_mm, 2)
    return np.asarray(cells_mm + np.tile(corners_mm[0], 2), np.float64)
