"""The printed board that cameras are calibrated with, as it stands in the bench file."""

from typing import Annotated, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

Vector = tuple[float, float, float]
SquareLength = Annotated[float, msgspec.Meta(gt=0, le=500)]
Squares = Annotated[int, msgspec.Meta(ge=3, le=60)]


class BoardPlace(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where a board stands in the robot frame while it lies at the base, with the stage at zero.

    `origin_mm` is the board's top left corner, of the squares and not of the paper, as one reads the board; `x_axis` points
    along its upper edge to the right, `y_axis` along its left edge downwards.
    """

    origin_mm: Vector
    x_axis: Vector
    y_axis: Vector

    @property
    def robot_from_board(self) -> NDArray[np.float64]:
        """(4, 4), with the board's z axis into the board."""
        x, y = np.array(self.x_axis), np.array(self.y_axis)
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        place = np.eye(4)
        place[:3, :3] = np.column_stack([x, y, np.cross(x, y)])
        place[:3, 3] = self.origin_mm
        return place

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        x, y = np.array(self.x_axis), np.array(self.y_axis)
        lengths = float(np.linalg.norm(x)), float(np.linalg.norm(y))
        if min(lengths) == 0 or abs(float(x @ y)) > 1e-3 * lengths[0] * lengths[1]:
            raise ValueError(
                f"x_axis {list(self.x_axis)} and y_axis {list(self.y_axis)} must be two directions at a right angle"
            )


class BoardSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The printed board that cameras are calibrated with; `nodal calibrate board` prints it.

    `squares` are columns and rows, the black ones included. `dictionary` and `marker_mm` are a ChArUco board's only;
    `legacy_pattern` is true for boards with an even number of rows that OpenCV before 4.6 made.
    """

    kind: Literal["charuco", "chessboard"] = "charuco"
    squares: tuple[Squares, Squares] = (9, 7)
    square_mm: SquareLength = 10.0
    """As measured on the paper: every length that the cameras see rests on it."""
    marker_mm: SquareLength = 7.0
    dictionary: Annotated[str, msgspec.Meta(pattern=r"^DICT_[A-Za-z0-9_]+$")] = "DICT_4X4_50"
    legacy_pattern: bool = False
    at_base: BoardPlace | None = None
    """Where the board stands for `nodal calibrate base`, if there is a fixture for it."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if self.kind == "charuco" and self.marker_mm >= self.square_mm:
            raise ValueError(
                f"marker_mm {self.marker_mm:g} must be less than square_mm {self.square_mm:g}, in which the markers lie"
            )
