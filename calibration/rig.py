"""What bundle adjustment solves for, and what it knows: cameras, poses of the board, the board's own shape, corners in pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array

SHAPE = ("bend_x_mm", "bend_y_mm", "twist_mm", "stretch", "shear")
"""How a printed board differs from what it should be: bent out of its plane along its sides and across its corners, by so much at
the outermost ones; and its y axis longer than it should be (`stretch`) and leaning over to x (`shear`), as shares of y.

Its size as a whole cannot be seen. Lengths along x are those that a ruler measured on the paper, and its origin stays where it is.
"""


@dataclass(frozen=True, eq=False)
class BoardShape:
    """The board as it is: corners that should be at `drawn_mm` (n, 3) go by `modes` (n, 3, k) for one of each of `amounts` (k,)."""

    amounts: Array = field(default_factory=lambda: np.zeros(0))
    modes: Array = field(default_factory=lambda: np.zeros((0, 3, 0)))
    drawn_mm: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @classmethod
    def of(cls, drawn_mm: Array, known: Mapping[str, float] = MappingProxyType({})) -> "BoardShape":
        """Any shape that SHAPE names of a board drawn with corners at `drawn_mm` (n, 3); flat and true but for what is known."""
        from_middle = drawn_mm[:, :2] - drawn_mm[:, :2].mean(axis=0)
        across, down = (from_middle / np.abs(from_middle).max(axis=0)).T
        modes = np.zeros((len(drawn_mm), 3, len(SHAPE)))
        modes[:, 2, 0], modes[:, 2, 1] = across**2 - np.mean(across**2), down**2 - np.mean(down**2)
        modes[:, 2, 2] = across * down
        modes[:, 1, 3] = modes[:, 0, 4] = drawn_mm[:, 1]
        return cls(np.array([known.get(name, 0.0) for name in SHAPE]), modes, drawn_mm)

    @property
    def points_mm(self) -> Array:
        """Where all corners are, (n, 3)."""
        return np.asarray(self.drawn_mm + self.modes @ self.amounts)

    @property
    def named(self) -> dict[str, float]:
        """Its amounts by the names of SHAPE."""
        return dict(zip(SHAPE, map(float, self.amounts), strict=True))

    @property
    def bow_mm(self) -> float:
        """How far apart its highest and its lowest corner are across the board's plane."""
        return float(np.ptp(self.points_mm[:, 2]))

    def moved(self, step: Array) -> "BoardShape":
        """The same, changed."""
        return replace(self, amounts=self.amounts + step)


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
        if not len(self.board.amounts):
            return seen.points_mm
        return np.asarray(seen.points_mm + self.board.modes[seen.ids] @ self.board.amounts)


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of any camera and board before they are seen, as standard deviations from none.

    `intrinsics` (9,) are infinite for what nothing is known of; `board` is of each mode of the board's shape (k,).
    """

    intrinsics: Array
    board: Array = field(default_factory=lambda: np.zeros(0))
