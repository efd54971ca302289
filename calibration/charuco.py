"""Finding a ChArUco board: markers say which corner is which, so that a part of the board is enough."""

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array, Missing, Picture
from calibration.errors import BoardError
from calibration.planes import homography, mapped
from messaging.board import BoardSettings

CLEAR = 0.6
"""How much of the white between an edge and the nearest marker is used; the rest is the blur of the marker's edge."""
MOST_NAMED = 4
MOST_MISPLACED = 1 / 6
"""Of the board's own markers: things that look like one are rare, and with fewer than five others nobody can tell which it is."""
MOST_OFF = 0.25
"""Squares: what tells a lens from a marker in another place, which is off by whole squares."""
MOST_SHARE_ERROR, OUTLINE_PX = 0.05, 1.5
"""In squares; and how exactly the outlines of markers are found."""


def charuco_board(settings: BoardSettings) -> cv2.aruco.CharucoBoard:
    """OpenCV's board, in mm; raises BoardError for an unknown dictionary, or one with too few markers."""
    number = getattr(cv2.aruco, settings.dictionary, None)
    if not isinstance(number, int):
        known = ", ".join(sorted(name for name in vars(cv2.aruco) if name.startswith("DICT_")))
        raise BoardError(f"board.dictionary: {settings.dictionary} is unknown; known are {known}")
    dictionary = cv2.aruco.getPredefinedDictionary(number)
    columns, rows = settings.squares
    needed, there = columns * rows // 2, len(dictionary.bytesList)
    if needed > there:
        raise BoardError(
            f"board.dictionary: {settings.dictionary} has {there} markers, "
            f"a board of {columns} x {rows} squares needs {needed}"
        )
    board = cv2.aruco.CharucoBoard(settings.squares, settings.square_mm, settings.marker_mm, dictionary)
    board.setLegacyPattern(settings.legacy_pattern)
    return board


class Charuco:
    """The finder of a ChArUco board; raises BoardError as `charuco_board` does."""

    def __init__(self, settings: BoardSettings) -> None:
        self._settings = settings
        self._board = charuco_board(settings)
        outlines = np.array(self._board.getObjPoints())[..., :2]
        self._outlines: Array = outlines.astype(np.float64) / settings.square_mm
        one_is_enough = cv2.aruco.CharucoParameters()
        one_is_enough.minMarkers = 1
        self._detector = cv2.aruco.CharucoDetector(self._board, one_is_enough)
        self.clear = CLEAR * 0.5 * (1.0 - settings.marker_mm / settings.square_mm)

    def find(self, grey: Picture) -> tuple[NDArray[np.int64], Array] | Missing:
        """Ids (n,) and pixels (n, 2) to start from, or the reason why there are none."""
        px, ids, outlines, seen = self._detector.detectBoard(grey)
        if seen is None or not len(seen):
            return Missing(f"no marker of {self._settings.dictionary} is in sight")
        markers, outlines_px = (
            np.ravel(seen).astype(np.int64),
            np.reshape(outlines, (-1, 4, 2)).astype(np.float64),
        )
        columns, rows = self._settings.squares
        own = markers < len(self._outlines)
        if np.count_nonzero(own) < np.count_nonzero(~own):
            strange = sorted(map(int, markers[~own]))
            named = ", ".join(map(str, strange[:MOST_NAMED])) + (", ..." if len(strange) > MOST_NAMED else "")
            return Missing(
                f"markers of another board: id {named}; those of this one go up to {len(self._outlines) - 1}"
            )
        placed = own.copy()
        placed[own] = self._placed(markers[own], outlines_px[own])
        if np.count_nonzero(own & ~placed) > MOST_MISPLACED * np.count_nonzero(own):
            return Missing(
                f"another layout: the markers do not lie as on a board of {columns} x {rows} squares"
            )
        if not placed.all():
            markers, outlines_px = markers[placed], outlines_px[placed]
            px, ids, _, _ = self._detector.detectBoard(
                grey,
                markerCorners=list(outlines_px[:, None].astype(np.float32)),
                markerIds=markers.astype(np.int32),
            )
        if ids is None or len(ids) < 4:
            return Missing(f"{len(markers)} markers are in sight, with hardly a corner between two of them")
        found = np.ravel(ids).astype(np.int64), np.reshape(px, (-1, 2)).astype(np.float64)
        share = self._marker_share(*found, outlines_px)
        printed = self._settings.marker_mm / self._settings.square_mm
        if share is not None and abs(share - printed) > MOST_SHARE_ERROR + OUTLINE_PX * share / _side(
            outlines_px
        ):
            return Missing(
                f"another layout: markers are {share:.2f} of a square wide, "
                f"board.marker_mm / board.square_mm says {printed:.2f}"
            )
        return found

    def _placed(self, markers: NDArray[np.int64], outlines_px: Array) -> NDArray[np.bool_]:
        """Which markers (n,) lie to one another as on the board; all, where too few or those of one line cannot tell."""
        centres_px, centres = outlines_px.mean(axis=1), self._outlines[markers].mean(axis=1)
        if homography(centres_px, centres) is None:
            return np.ones(len(markers), np.bool_)
        _, placed = cv2.findHomography(centres_px, centres, cv2.RANSAC, MOST_OFF)
        return np.asarray(placed, np.bool_).ravel()

    def _marker_share(self, ids: NDArray[np.int64], px: Array, outlines_px: Array) -> float | None:
        """How wide the markers are, in squares; None where corners in a line do not tell."""
        columns = self._settings.squares[0] - 1
        board_from_picture = homography(
            px, np.column_stack([ids % columns, ids // columns]).astype(np.float64)
        )
        if board_from_picture is None:
            return None
        return _side(mapped(board_from_picture, outlines_px))


def _side(outlines: Array) -> float:
    """How long the sides of quadrangles (n, 4, 2) are."""
    return float(np.median(np.linalg.norm(outlines - np.roll(outlines, 1, axis=1), axis=2)))
