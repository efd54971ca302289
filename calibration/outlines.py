"""How a view looks, in a few numbers: where the board's outline lies in each picture. Like views have like outlines."""

from collections.abc import Mapping

import numpy as np

from calibration.board import Board
from calibration.corners import Array
from calibration.planes import homography, mapped
from calibration.views import Size, View

ALIKE = 0.03
"""Outlines closer than this many widths of the picture (RMS of their four corners) show the same once more."""

Outlines = Mapping[str, Array]
"""By camera: the four corners (4, 2) of the board's outline, in widths of the picture; seen or not, in the picture or not."""


def outlines(board: Board, view: View, sizes: Mapping[str, Size]) -> Outlines:
    """Where the board's outline lies in the pictures of a view."""
    columns, rows = board.settings.squares
    around = board.settings.square_mm * np.array(
        [[0, 0], [columns, 0], [columns, rows], [0, rows]], np.float64
    )
    found: dict[str, Array] = {}
    for camera, corners in view.corners.items():
        picture_from_board = homography(board.points_mm[corners.ids, :2], corners.px)
        if picture_from_board is not None:
            found[camera] = mapped(picture_from_board, around) / sizes[camera][0]
    return found


def apart(one: Outlines, other: Outlines) -> float:
    """How differently two views look, in widths of the picture, in the camera that sees most of it; infinite if not the same
    cameras see them.
    """
    if one.keys() != other.keys() or not one:
        return float("inf")
    return max(float(np.sqrt(np.mean(np.sum((one[camera] - other[camera]) ** 2, axis=1)))) for camera in one)
