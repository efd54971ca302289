"""Views of a board in, calibrated cameras out, with what speaks for them and against them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.board import Board
from calibration.camera_set import CameraSet
from calibration.corners import Array, Corners
from calibration.views import Size, View


@dataclass(frozen=True, eq=False)
class Sighting:
    """One view in one camera: its corners, and `residual_px` (n, 2), found minus predicted by the solution."""

    view: str
    camera: str
    corners: Corners
    residual_px: Array

    @property
    def rms_px(self) -> float:
        """Over both coordinates of all corners."""
        return float(np.sqrt(np.mean(self.residual_px**2)))


@dataclass(frozen=True, eq=False)
class Calibration:
    """The cameras, and all that a report says about them.

    `rig_from_board` are the board's poses (4, 4), mm, by view. `parameters` name the rows and columns of `covariance`:
    "CAMERA.NAME" with the names of `CalibratedCamera.sigma`. Rejected views are in `cameras.views_rejected`.
    """

    cameras: CameraSet
    sightings: tuple[Sighting, ...]
    rig_from_board: Mapping[str, Array]
    parameters: tuple[str, ...]
    covariance: Array


def calibrate(board: Board, views: Sequence[View], sizes: Mapping[str, Size]) -> Calibration:
    """Calibrate all cameras of `sizes` (width, height, px; the first one's frame is the rig's) with one bundle adjustment.

    Raises ViewsError where the views do not determine the cameras.
    """
    raise NotImplementedError
