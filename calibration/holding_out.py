"""How well cameras predict views that they were not calibrated with."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from calibration.board import Board
from calibration.bundle import Adjusted, adjust
from calibration.camera_set import BoardCheck
from calibration.corners import Array
from calibration.posing import board_pose, off_px, triangulated
from calibration.rig import Observation, Prior, Rig

FOLDS = 5
FEWEST_TO_HOLD_OUT = 3
"""Of views that the same cameras see: with fewer, what is left may not tie these cameras together."""
FEWEST_MEASURED = 8
"""Corners of a view that all its cameras see: fewer always lie nearly in a plane."""


@dataclass(frozen=True)
class HeldOut:
    """`rms_px` (c,) by camera, nan where nothing could be held out; the squares are None where no two cameras saw any."""

    rms_px: Array
    squares: BoardCheck | None


def hold_out(board: Board, solved: Adjusted, observations: Sequence[Observation], prior: Prior) -> HeldOut:
    """Solve again without a fifth of the views at a time, and look at those.

    The error of a camera is RMS, per coordinate, of corners in held-out views against where the *other* cameras say that they
    are: these give the board's pose and this camera has no part in it, so errors of all intrinsics and of how the cameras
    stand to one another count. Where no other camera sees the view, every second corner gives the pose and the others are predicted.
    """
    errors: list[list[Array]] = [[] for _ in solved.noise_px]
    sides: list[Array] = []
    heights: list[Array] = []
    for held in _folds(observations):
        kept = [one for one in observations if one.view not in held]
        rig = adjust(solved.rig, kept, prior, solved.noise_px).rig
        for view in held:
            seen = [one for one in observations if one.view == view]
            for one in seen:
                errors[one.camera].append(
                    _predicted_off(rig, one, [other for other in seen if other is not one])
                )
            for points_mm in _measured(board, rig, seen):
                sides.append(_sides_mm(points_mm))
                heights.append(_heights_mm(points_mm))
    rms = [float(np.sqrt(np.mean(np.concatenate(one) ** 2))) if one else float("nan") for one in errors]
    return HeldOut(np.array(rms), _check(board, sides, heights))


def _folds(observations: Sequence[Observation]) -> Iterator[set[int]]:
    """Views to hold out at a time; views that the same cameras see are spread over all folds."""
    seen_by: dict[int, frozenset[int]] = {}
    for one in observations:
        seen_by[one.view] = seen_by.get(one.view, frozenset()) | {one.camera}
    groups: dict[frozenset[int], list[int]] = {}
    for view, cameras in seen_by.items():
        groups.setdefault(cameras, []).append(view)
    folds: list[set[int]] = [set() for _ in range(FOLDS)]
    place = 0
    for group in groups.values():
        if len(group) >= FEWEST_TO_HOLD_OUT:
            for view in group:
                folds[place % FOLDS].add(view)
                place += 1
    yield from filter(None, folds)


def _predicted_off(rig: Rig, one: Observation, others: Sequence[Observation]) -> Array:
    if others:
        return off_px(rig, board_pose(rig, others), one)
    halves = [one.only(np.s_[start::2]) for start in (0, 1)]
    return off_px(rig, board_pose(rig, halves[:1]), halves[1])


def _measured(board: Board, rig: Rig, seen: Sequence[Observation]) -> Iterator[Array]:
    """The board's corners (rows, columns, 3) in 3-D, mm, from all cameras that see the view; nan where not all see one."""
    if len(seen) < 2:
        return
    common = reduce(np.intersect1d, [one.ids for one in seen])
    if len(common) < FEWEST_MEASURED:
        return
    px = np.array([one.px[np.searchsorted(one.ids, common)] for one in seen])
    grid = np.full((board.rows * board.columns, 3), np.nan)
    grid[common] = triangulated(rig, [one.camera for one in seen], px)
    yield grid.reshape(board.rows, board.columns, 3)


def _sides_mm(grid_mm: Array) -> Array:
    lengths = [np.linalg.norm(np.diff(grid_mm, axis=axis), axis=2).ravel() for axis in (0, 1)]
    return np.concatenate([one[np.isfinite(one)] for one in lengths])


def _heights_mm(grid_mm: Array) -> Array:
    points_mm = grid_mm.reshape(-1, 3)
    points_mm = points_mm[np.isfinite(points_mm[:, 0])]
    away = points_mm - points_mm.mean(axis=0)
    return np.asarray(away @ np.linalg.svd(away, full_matrices=False)[2][2])


def _check(board: Board, sides: Sequence[Array], heights: Sequence[Array]) -> BoardCheck | None:
    errors = np.concatenate([*sides, np.empty(0)]) - board.settings.square_mm
    if not len(errors):
        return None
    return BoardCheck(
        squares=len(errors),
        mean_error_mm=float(errors.mean()),
        rms_error_mm=float(np.sqrt(np.mean(errors**2))),
        flatness_mm=float(np.sqrt(np.mean(np.concatenate(heights) ** 2))),
    )
