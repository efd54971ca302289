"""Views of the board out of what cameras see: looked at one after another, and taken where they show something new."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator

import cv2
import numpy as np

from calibration.board import Board
from calibration.corners import Picture
from calibration.coverage import Coverage, Verdict
from calibration.views import Size, View, find_view
from drivers.cameras import CameraFrame, FrameSet
from nodal.calibrate.cameras.kept_views import NewViews

MEASURED = re.compile(r"\d+\.\d+")
"""What differs between two reasons of the same kind; whole numbers name views and dictionaries."""
AS_TAKEN = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
LOOK_APART_S = 0.15
"""Between two looks at a stream: long enough for a board that moves to be seen moving."""
READ_OUT_S = 0.005
"""Cameras read a picture row by row: even two that are in step see one place of a board about so long after one another."""
ALLOWED_SHIFT_PX = 0.2
"""Of a board that moves, between the cameras' pictures. It points another way in every view, so that little of it is left in
the cameras (docs/calibration.md)."""
NS_PER_S = 1e9


class Taking:
    """Looks at frame sets of a stream, in which the board moves, or at pictures that were taken `one_by_one`."""

    def __init__(self, board: Board, cameras: Iterable[str], kept: NewViews, *, one_by_one: bool) -> None:
        self.cameras = tuple(cameras)
        self._board = board
        self._kept = kept
        self._one_by_one = one_by_one
        self._looked_ns: int | None = None
        self._before: View | None = None
        self.sizes: dict[str, Size] = {}
        """Of the pictures, once a first frame set told."""
        self.coverage: Coverage | None = None
        """None until then."""
        self.view: View | None = None
        """The last one that was looked at."""
        self.verdict: Verdict | None = None
        """On it."""
        self.views: list[View] = []
        """Those that were taken: of pictures that somebody took one by one all, since calibration says which it leaves out."""
        self.refused: Counter[str] = Counter()
        """How many were not taken, by the kind of the reason."""

    @property
    def missing(self) -> tuple[str, ...]:
        """What to show next, in words."""
        return self.coverage.missing() if self.coverage else ("the board, before all cameras",)

    def look(self, frame_set: FrameSet) -> bool:
        """Look at it, unless the last look is too short a while ago; returns whether it was looked at."""
        now_ns = frame_set.capture_monotonic_ns
        passed_s = None if self._looked_ns is None else (now_ns - self._looked_ns) / NS_PER_S
        if not self._one_by_one and passed_s is not None and passed_s < LOOK_APART_S:
            return False
        self._looked_ns = now_ns
        self.view = self._found(frame_set)
        self.verdict = self._judged(self.view, passed_s, frame_set.skew_s)
        self._before = self.view
        if self.verdict.taken or self._one_by_one:
            self.views.append(self.view)
            self._kept.keep(self.view.name, frame_set.frames)
        else:
            self.refused[MEASURED.sub("…", self.verdict.reason)] += 1
        return True

    def _found(self, frame_set: FrameSet) -> View:
        number = frame_set.frames[0].number if self._one_by_one else len(self.views) + 1
        pictures = {
            frame.name: picture for frame in frame_set.frames if (picture := _decoded(frame)) is not None
        }
        return find_view(self._board, f"{number:02d}", pictures)

    def _judged(self, view: View, passed_s: float | None, skew_s: float) -> Verdict:
        if self.coverage is None:
            if silent := [camera for camera in self.cameras if camera not in view.sizes]:
                return Verdict(taken=False, reason=f"no picture of camera {', '.join(silent)}")
            self.sizes = {camera: view.sizes[camera] for camera in self.cameras}
            self.coverage = Coverage(self._board, self.sizes)
        if view.corners and not self._one_by_one and not self._is_still(view, passed_s, skew_s):
            return Verdict(taken=False, reason="hold the board still")
        return self.coverage.offer(view)

    def _is_still(self, view: View, passed_s: float | None, skew_s: float) -> bool:
        """Whether the board, moving as it did since it was last looked at, is at the same place for all cameras."""
        moved_px = _moved_px(self._before, view)
        if passed_s is None or moved_px is None:
            return False
        return moved_px / passed_s * (skew_s + READ_OUT_S) <= ALLOWED_SHIFT_PX


def newest(frame_sets: Iterator[FrameSet | None]) -> Iterator[FrameSet | None]:
    """Of the sets that wait to be looked at, the newest; None when there is none."""
    last = None
    for frame_set in frame_sets:
        if frame_set is None:
            yield last
        last = frame_set


def _decoded(frame: CameraFrame) -> Picture | None:
    """A picture that cannot be decoded is like one in which no board is seen."""
    picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), AS_TAKEN) if frame.jpeg else None
    return None if picture is None else np.asarray(picture, np.uint8)


def _moved_px(before: View | None, now: View) -> float | None:
    """The median over the corners that a camera saw both times, of the camera that saw most; None when none did."""
    moved = []
    for camera, corners in now.corners.items():
        earlier = before.corners.get(camera) if before else None
        if earlier is None:
            continue
        _, here, there = np.intersect1d(corners.ids, earlier.ids, return_indices=True)
        if len(here):
            moved.append(float(np.median(np.linalg.norm(corners.px[here] - earlier.px[there], axis=1))))
    return max(moved, default=None)
