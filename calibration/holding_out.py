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
    surface: list[Array] = []
    for held in _folds(observations):
        kept = [one for one in observations if one.view not in held]
        rig = adjust(solved.rig, kept, prior, solved.noise_px).rig
        for view in held:
            seen = [one for one in observations if one.view == view]
            for one in seen:
                errors[one.camera].append(
                    _predicted_off(rig, one, [other for other in seen if other is not one])
                )
            for grid_mm in _measured(board, rig, seen):
                sides.append(_sides_off_mm(grid_mm, rig.board.points_mm.reshape(grid_mm.shape)))
                surface.append(_surface_off_mm(grid_mm.reshape(-1, 3), rig.board.points_mm))
    rms = [_rms(np.concatenate(one)) if one else float("nan") for one in errors]
    return HeldOut(np.array(rms), _check(sides, surface))


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


def _sides_off_mm(measured_mm: Array, solved_mm: Array) -> Array:
    """How much longer sides of squares are in one grid of corners (rows, columns, 3) than in the other, where both are known."""
    off = [(_lengths(measured_mm, axis) - _lengths(solved_mm, axis)).ravel() for axis in (0, 1)]
    return np.concatenate([one[np.isfinite(one)] for one in off])


def _lengths(grid_mm: Array, axis: int) -> Array:
    return np.asarray(np.linalg.norm(np.diff(grid_mm, axis=axis), axis=2))


def _surface_off_mm(measured_mm: Array, solved_mm: Array) -> Array:
    """How far corners (n, 3) are above the board, which is laid onto them as well as a rigid body can be (Kabsch)."""
    known = np.isfinite(measured_mm[:, 0])
    measured, solved = (points[known] - points[known].mean(axis=0) for points in (measured_mm, solved_mm))
    left, _, right = np.linalg.svd(measured.T @ solved)
    left[:, 2] *= np.linalg.det(left @ right)
    return np.asarray((measured @ left @ right - solved)[:, 2])


def _check(sides: Sequence[Array], surface: Sequence[Array]) -> BoardCheck | None:
    off_mm = np.concatenate([*sides, np.empty(0)])
    if not len(off_mm):
        return None
    return BoardCheck(
        squares=len(off_mm),
        mean_error_mm=float(off_mm.mean()),
        rms_error_mm=_rms(off_mm),
        surface_error_mm=_rms(np.concatenate(surface)),
    )


def _rms(off: Array) -> float:
    return float(np.sqrt(np.mean(off**2)))
