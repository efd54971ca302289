"""The board as all cameras saw it at one moment."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from calibration.board import Board
from calibration.corners import Corners, Picture

Size = tuple[int, int]
"""Width and height in px."""


@dataclass(frozen=True, eq=False)
class View:
    """One moment: the corners by camera, and by camera why there are none. `sizes` are the pictures' (width, height) in px."""

    name: str
    corners: Mapping[str, Corners]
    missing: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, Size] = field(default_factory=dict)

    def seen_by(self, cameras: Collection[str]) -> "View":
        """What these cameras saw."""
        return View(
            self.name,
            {camera: corners for camera, corners in self.corners.items() if camera in cameras},
            {camera: reason for camera, reason in self.missing.items() if camera in cameras},
            {camera: size for camera, size in self.sizes.items() if camera in cameras},
        )

    @property
    def blur_px(self) -> dict[str, float]:
        """The median blur of each camera's corners: what defocus and motion did to the edges."""
        return {camera: float(np.median(corners.blur_px)) for camera, corners in self.corners.items()}


def find_view(board: Board, name: str, pictures: Mapping[str, Picture]) -> View:
    """Look for the board in each camera's picture of one moment."""
    found = {camera: board.find(picture) for camera, picture in pictures.items()}
    return View(
        name=name,
        corners={camera: one for camera, one in found.items() if isinstance(one, Corners)},
        missing={camera: one.reason for camera, one in found.items() if not isinstance(one, Corners)},
        sizes={camera: (picture.shape[1], picture.shape[0]) for camera, picture in pictures.items()},
    )
