"""Views of a board in, calibrated cameras out, with what speaks for them and against them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from calibration.board import Board
from calibration.bundle import Adjusted, adjust
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.corners import Array, Corners
from calibration.doubts import check, standard_deviations
from calibration.errors import ViewsError
from calibration.holding_out import HeldOut, hold_out
from calibration.picking import FEWEST_VIEWS, pick
from calibration.projection import INTRINSICS, POSE, matrix
from calibration.rig import SHAPE, BoardShape, Observation, Prior
from calibration.starting import starting_rig
from calibration.views import Size, View
from calibration.weeding import weed

LENSES = np.array([np.inf, np.inf, np.inf, np.inf, 0.5, 0.5, 0.005, 0.005, 0.25])
"""Lenses distort by no more than this, more or less. Views all over the picture say it a hundred times better; where views
lie in its middle only, this keeps terms that nothing determines from growing wild (docs/calibration.md)."""
PRINTS = np.array([0.5, 0.5, 0.5, 0.005, 0.005])
"""Boards are bent by no more than this, more or less, and printed true to it."""
RIGID, PRIOR = Prior(LENSES), Prior(LENSES, PRINTS)
WEEDINGS = 4
NAMES = (*INTRINSICS, *POSE)


@dataclass(frozen=True, eq=False)
class Sighting:
    """One view in one camera: the corners that were used, and `residual_px` (n, 2), found minus predicted by the solution."""

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
    "CAMERA.NAME" with the names of `CalibratedCamera.sigma`, and "board.NAME" with those of `CameraSet.board_shape`. Rejected views are in `cameras.views_rejected`.
    """

    cameras: CameraSet
    sightings: tuple[Sighting, ...]
    rig_from_board: Mapping[str, Array]
    parameters: tuple[str, ...]
    covariance: Array


def calibrate(board: Board, views: Sequence[View], sizes: Mapping[str, Size]) -> Calibration:
    """Calibrate all cameras of `sizes` (width, height, px; the first one's frame is the rig's) with one bundle adjustment.

    Views that show nothing new, are blurred, or do not fit the others are left away and named. When the cameras were
    calibrated is for the caller to say. Raises ViewsError where the views do not determine the cameras.
    """
    names = tuple(sizes)
    picked = pick(board, views, sizes)
    found = {view.name: view for view in picked.views}
    shown = list(found)
    observations = _observations(board, names, picked.views)
    rejected = dict(picked.rejected)
    rigid = starting_rig(names, sizes, observations, RIGID)
    rig = replace(rigid, board=BoardShape.of(board.points_mm))
    for _ in range(WEEDINGS):
        solved = adjust(rig, observations, PRIOR)
        weeded = weed(names, solved, observations)
        rejected |= {shown[view]: reason for view, reason in weeded.bad_views.items()}
        if sum(map(_corners, weeded.observations)) == sum(map(_corners, observations)):
            break
        _check_left(names, weeded.observations, rejected)
        left = sorted({one.view for one in weeded.observations})
        observations = [replace(one, view=left.index(one.view)) for one in weeded.observations]
        shown = [shown[view] for view in left]
        rig = replace(solved.rig, rig_from_board=solved.rig.rig_from_board[left])
    else:
        solved = adjust(rig, observations, PRIOR)
    check(names, sizes, solved)
    held_out = hold_out(board, solved, observations, PRIOR)
    sightings = tuple(
        _sighting(found[shown[one.view]], names[one.camera], one, residual_px)
        for one, residual_px in zip(observations, solved.residual_px, strict=True)
    )
    cameras = CameraSet(
        cameras=tuple(
            _camera(names, sizes, number, solved, sightings, held_out) for number in range(len(names))
        ),
        board=board.settings,
        views_used=len(shown),
        views_rejected=rejected,
        board_check=held_out.squares,
        board_shape=solved.rig.board.named,
    )
    free = np.flatnonzero(np.diag(solved.covariance))
    return Calibration(
        cameras=cameras,
        sightings=sightings,
        rig_from_board=dict(zip(shown, solved.rig.rig_from_board, strict=True)),
        parameters=tuple(_parameters(names)[one] for one in free),
        covariance=solved.covariance[np.ix_(free, free)],
    )


def _parameters(names: Sequence[str]) -> list[str]:
    return [*(f"{camera}.{name}" for camera in names for name in NAMES), *(f"board.{name}" for name in SHAPE)]


def _corners(one: Observation) -> int:
    return len(one.ids)


def _observations(board: Board, names: Sequence[str], views: Sequence[View]) -> list[Observation]:
    return [
        Observation(names.index(camera), number, corners.ids, board.points_mm[corners.ids], corners.px)
        for number, view in enumerate(views)
        for camera, corners in view.corners.items()
        if camera in names
    ]


def _check_left(
    names: Sequence[str], observations: Sequence[Observation], rejected: Mapping[str, str]
) -> None:
    for camera, name in enumerate(names):
        left = sum(one.camera == camera for one in observations)
        if left < FEWEST_VIEWS:
            view, reason = list(rejected.items())[-1]
            raise ViewsError(
                f"camera {name} is left with {left} views that agree with one another, at least {FEWEST_VIEWS} are needed; "
                f"of the others, view {view}: {reason}"
            )


def _sighting(view: View, camera: str, used: Observation, residual_px: Array) -> Sighting:
    all_corners = view.corners[camera]
    return Sighting(view.name, camera, all_corners.only(np.isin(all_corners.ids, used.ids)), residual_px)


def _camera(
    names: Sequence[str],
    sizes: Mapping[str, Size],
    number: int,
    solved: Adjusted,
    sightings: Sequence[Sighting],
    held_out: HeldOut,
) -> CalibratedCamera:
    own = [one for one in sightings if one.camera == names[number]]
    intrinsics, held_out_px = solved.rig.intrinsics[number], float(held_out.rms_px[number])
    sigma = dict(zip(NAMES, map(float, standard_deviations(solved)[number]), strict=True))
    width, height = sizes[names[number]]
    known = {
        "name": names[number],
        "width_px": width,
        "height_px": height,
        "intrinsics": matrix(intrinsics).tolist(),
        "distortion": intrinsics[4:].tolist(),
        "camera_from_rig": solved.rig.camera_from_rig[number].tolist(),
        "sigma": {name: value for name, value in sigma.items() if value > 0},
        "views": len(own),
        "rms_px": float(np.sqrt(np.mean(np.concatenate([one.residual_px for one in own]) ** 2))),
        "held_out_rms_px": held_out_px if np.isfinite(held_out_px) else None,
    }
    return msgspec.convert(known, CalibratedCamera)
