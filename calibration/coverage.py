"""What the views so far have shown of the cameras, and what to show next: for a person who moves the board."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.board import Board
from calibration.outlines import ALIKE, Outlines, apart, outlines
from calibration.picking import SHARP_QUANTILE, too_blurred
from calibration.rig import Observation
from calibration.starting import pose_alone
from calibration.views import Size, View

GUESSED_FOCAL = 0.8
"""In widths of the picture, as webcams have it: exact enough to tell tilts from one another before anything is calibrated."""
ENOUGH_VIEWS, ENOUGH_SHARED = 20, 12
ENOUGH_CORNERS = 3
"""In a ninth of the picture, over all views."""
ENOUGH_TILT_RAD = np.radians(30.0)
"""Between the most different views: foreshortening is what tells the focal length from the distance."""
ENOUGH_DISTANCE = 1.15
"""Of the farthest view, over that of the nearest."""
ROWS, COLUMNS = ("upper", "middle", "lower"), ("left", "middle", "right")


@dataclass(frozen=True)
class Verdict:
    """Whether a view was taken, and why or why not, in words."""

    taken: bool
    reason: str


class Coverage:
    """Judges one view after another; `sizes` are (width, height) in px by camera. `views` are those that were taken."""

    def __init__(self, board: Board, sizes: Mapping[str, Size]) -> None:
        self.views: list[View] = []
        self._board, self._sizes = board, sizes
        self._looks: list[Outlines] = []
        self._seen = {camera: _Seen(size) for camera, size in sizes.items()}
        self._blurs: dict[str, list[float]] = {camera: [] for camera in sizes}

    def offer(self, view: View) -> Verdict:
        """Take a view that shows something new and is sharp enough; refuse any other."""
        if not view.corners:
            reasons = [f"{camera}: {reason}" for camera, reason in view.missing.items()]
            return Verdict(False, "; ".join(reasons) or "no camera sees the board")
        for camera, blur_px in view.blur_px.items():
            blurs = self._blurs[camera]
            blurs.append(blur_px)
            if too_blurred(blur_px, float(np.quantile(blurs, SHARP_QUANTILE))):
                return Verdict(False, f"{camera}: blurred over {blur_px:.1f} px: hold the board still")
        look = outlines(self._board, view, self._sizes)
        for before, other in zip(self.views, self._looks, strict=True):
            if apart(look, other) < ALIKE:
                return Verdict(False, f"shows the same as view {before.name}: move or tilt the board")
        self.views.append(view)
        self._looks.append(look)
        for camera, corners in view.corners.items():
            points_mm = self._board.points_mm[corners.ids]
            self._seen[camera].add(Observation(0, 0, corners.ids, points_mm, corners.px))
        where = " and ".join(
            f"{len(corners)} corners in {camera}" for camera, corners in view.corners.items()
        )
        return Verdict(True, where)

    def grid(self, camera: str) -> NDArray[np.int64]:
        """How many corners (3, 3) lay in each ninth of the camera's picture, in all views together."""
        return self._seen[camera].grid.copy()

    def empty_ninths(self, camera: str) -> int:
        """How many ninths of the camera's picture hardly a corner lay in, in all views together."""
        return int(np.count_nonzero(self._seen[camera].grid < ENOUGH_CORNERS))

    def missing(self) -> tuple[str, ...]:
        """What to show next, most wanted first, in words that a person can follow; empty when it is enough."""
        return (*self._missing_shared(), *(words for seen in self._seen.items() for words in _wanted(*seen)))

    @property
    def enough(self) -> bool:
        """Whether nothing is missing."""
        return not self.missing()

    def _missing_shared(self) -> Iterator[str]:
        """A tree of cameras is enough, in which each shares views with one that is in it already."""
        cameras = list(self._sizes)
        tied = cameras[:1]
        while len(tied) < len(cameras):
            shared, known, new = max(
                (
                    (self._shared(one, other), one, other)
                    for one in tied
                    for other in cameras
                    if other not in tied
                ),
                key=lambda found: found[0],
            )
            if shared < ENOUGH_SHARED:
                yield f"more views that {known} and {new} both see: {shared} of {ENOUGH_SHARED}"
            tied.append(new)

    def _shared(self, one: str, other: str) -> int:
        return sum(one in view.corners and other in view.corners for view in self.views)


class _Seen:
    """What one camera has seen: corners by ninth of its picture, and the board's tilts (n, 2) and distances (n,)."""

    def __init__(self, size: Size) -> None:
        width, height = size
        self.size = size
        self.grid = np.zeros((3, 3), np.int64)
        self.tilts_rad: list[tuple[float, float]] = []
        self.distances_mm: list[float] = []
        focal_px = GUESSED_FOCAL * width
        self._guess = np.array([focal_px, focal_px, (width - 1) / 2, (height - 1) / 2, 0, 0, 0, 0, 0])

    def add(self, seen: Observation) -> None:
        width, height = self.size
        columns, rows = (seen.px * 3 / (width, height)).astype(np.int64).clip(0, 2).T
        np.add.at(self.grid, (rows, columns), 1)
        pose, _ = pose_alone(self._guess, seen)
        across, down, ahead = pose[:3, 2]
        self.tilts_rad.append((float(np.arctan2(across, ahead)), float(np.arctan2(down, ahead))))
        middle_mm = seen.points_mm.mean(axis=0)
        self.distances_mm.append(float((pose[:3, :3] @ middle_mm + pose[:3, 3])[2]))


def _wanted(camera: str, seen: _Seen) -> Iterator[str]:
    views = len(seen.distances_mm)
    if not views:
        yield f"{camera}: has not seen the board yet"
        return
    (least_across, least_down), (most_across, most_down) = (
        np.min(seen.tilts_rad, 0),
        np.max(seen.tilts_rad, 0),
    )
    if most_across - least_across < ENOUGH_TILT_RAD:
        yield f"{camera}: tilt the board more about its vertical axis, by turns to the left and to the right"
    if most_down - least_down < ENOUGH_TILT_RAD:
        yield f"{camera}: tilt the board more about its horizontal axis, by turns forwards and backwards"
    for row, column in np.argwhere(seen.grid < ENOUGH_CORNERS):
        place = f"{ROWS[row]} {COLUMNS[column]}"
        yield f"{camera}: nothing in the {'middle' if row == column == 1 else place} of the picture"
    if max(seen.distances_mm) < ENOUGH_DISTANCE * min(seen.distances_mm):
        yield f"{camera}: hold the board nearer and farther"
    if views < ENOUGH_VIEWS:
        yield f"{camera}: more views: {views} of {ENOUGH_VIEWS}"
