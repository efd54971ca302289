"""What one camera saw of the board: its inner corners, or the reason why there are none."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
"""(height, width) grey or (height, width, 3) BGR."""


@dataclass(frozen=True, eq=False)
class Corners:
    """Inner corners of the board that were found in one picture.

    `ids` (n,) ascend and count along the board's rows from its top left corner, `px` (n, 2) are sub-pixel, integer coordinates being
    pixel centres. `blur_px` (n,) is the standard deviation of the blur across the corner's edges, the larger of both.
    """

    ids: NDArray[np.int64]
    px: Array
    blur_px: Array

    def __len__(self) -> int:
        return len(self.ids)

    def only(self, chosen: NDArray[np.bool_]) -> "Corners":
        """Some of them."""
        return Corners(self.ids[chosen], self.px[chosen], self.blur_px[chosen])


@dataclass(frozen=True)
class Missing:
    """Why no board was found in a picture, in words."""

    reason: str
