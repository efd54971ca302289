"""What bundle adjustment solves for, and what it knows: cameras, poses of the board, the board's own shape, corners in pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array

SHAPE = ("bend_x_mm", "bend_y_mm", "twist_mm", "stretch_mm", "shear_mm")
"""How a printed board differs from what it should be: bent out of its plane along its sides and across its corners, and printed
longer one way than the other, or askew. Its size as a whole cannot be seen, and is what was measured on the paper."""


@dataclass(frozen=True, eq=False)
class BoardShape:
    """The board as it is: `modes` (n, 3, k) are how far each corner goes for one mm of each of `mm` (k,)."""

    mm: Array = field(default_factory=lambda: np.zeros(0))
    modes: Array = field(default_factory=lambda: np.zeros((0, 3, 0)))

    @classmethod
    def of(cls, points_mm: Array, known_mm: Mapping[str, float] = MappingProxyType({})) -> "BoardShape":
        """Any shape that SHAPE names of a board with corners at `points_mm` (n, 3); flat and true but for what is known.

        Each of its mm is reached at the outermost corners.
        """
        from_middle = points_mm[:, :2] - points_mm[:, :2].mean(axis=0)
        across, down = (from_middle / np.abs(from_middle).max(axis=0)).T
        even = from_middle / np.abs(from_middle).max()
        modes = np.zeros((len(points_mm), 3, len(SHAPE)))
        modes[:, 2, 0], modes[:, 2, 1] = across**2 - np.mean(across**2), down**2 - np.mean(down**2)
        modes[:, 2, 2] = across * down
        modes[:, 0, 3], modes[:, 1, 3] = even[:, 0], -even[:, 1]
        modes[:, 0, 4], modes[:, 1, 4] = even[:, 1], even[:, 0]
        return cls(np.array([known_mm.get(name, 0.0) for name in SHAPE]), modes)

    def moved(self, step_mm: Array) -> "BoardShape":
        """The same, changed."""
        return replace(self, mm=self.mm + step_mm)


@dataclass(frozen=True, eq=False)
class Observation:
    """Corners `ids` (n,) of the board, `px` (n, 2) and `points_mm` (n, 3) on it, seen by one camera in one view, both by number."""

    camera: int
    view: int
    ids: NDArray[np.int64]
    points_mm: Array
    px: Array

    def only(self, chosen: NDArray[np.bool_] | slice) -> "Observation":
        """Some of its corners."""
        return replace(self, ids=self.ids[chosen], points_mm=self.points_mm[chosen], px=self.px[chosen])


@dataclass(frozen=True, eq=False)
class Rig:
    """A solution: `intrinsics` (c, 9), `camera_from_rig` (c, 4, 4) and `rig_from_board` (v, 4, 4), mm, and the board's shape.

    The first camera's `camera_from_rig` stays what it is. A board without modes of shape is rigid.
    """

    intrinsics: Array
    camera_from_rig: Array
    rig_from_board: Array
    board: BoardShape = field(default_factory=BoardShape)

    def points_mm(self, seen: Observation) -> Array:
        """Where the corners are on the board as it is, (n, 3)."""
        if not len(self.board.mm):
            return seen.points_mm
        return np.asarray(seen.points_mm + self.board.modes[seen.ids] @ self.board.mm)


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of any camera and board before they are seen, as standard deviations from none.

    `intrinsics` (9,) are infinite for what nothing is known of; `board_mm` is of each mode of the board's shape (k,).
    """

    intrinsics: Array
    board_mm: Array = field(default_factory=lambda: np.zeros(0))
