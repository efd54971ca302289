"""Corners between four squares to a few hundredths of a pixel: a model of the crossing is fitted to the picture around it.

Two straight edges cross. Brightness has one level on two opposite quarters and another one on the other two, both may slope
across the window, and each edge is blurred by a Gaussian of its own: all that a camera adds, short of noise. So pixels far
along the edges count too. Refinement by gradients (cv2.cornerSubPix) has no such model and must stay clear of the markers:
against exact corners its error is three times as large (`python -m benchmarks.calibration`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from calibration.corners import Array, Picture

MOST_STEPS = 8
SETTLED_PX = 2e-3
LONGEST_ARM_PX = 32.0
WIDEST_CLEAR_PX = 4.5
"""Pixels farther from an edge say nothing about where it is."""
START_BLUR_PX = 0.8
BLUR_PX = 0.25, 8.0
FARTHEST_SIDES, FARTHEST_PX = 0.06, (0.75, 2.5)
"""A sound crossing lies near where it was looked for: in shares of a side, but within these bounds."""
UNSETTLED_PX = 0.05
MOST_BLUR_SIDES, MOST_MISFIT = 0.12, 0.2
"""Edges that are as blurred as a marker is wide cannot be told from it; and what is left, in shares of the contrast."""
LEAST_CONTRAST = 8.0
"""Grey levels of 255 between black and white."""
SHAPES, LEVELS = 6, 6
"""Unknowns: the place, two directions, two blurs; two levels with two slopes each."""


@dataclass(frozen=True, eq=False)
class Saddles:
    """What was fitted at n starting points: `px` (n, 2), `blur_px` (n,) across the more blurred edge, `sound` (n,) bool."""

    px: Array
    blur_px: Array
    sound: NDArray[np.bool_]


def refine(grey: Picture, start_px: Array, sides_px: Array, arm: float, clear: float) -> Saddles:
    """Fit the crossings near `start_px` (n, 2) by Gauss-Newton steps.

    `sides_px` (n, 2, 2) holds in its rows the two sides of a square as they lie in the picture at each corner. Pixels count
    that lie within `arm` of the corner along both sides and within `clear` of an edge, in shares of a side. A fit that runs
    away, does not settle, or leaves much of the picture unexplained is not sound.
    """
    levels, offsets, weights = _windows(grey, start_px, sides_px, arm, clear)
    scale = 1.0 / max(1.0, float(np.abs(offsets).max()))
    count = len(start_px)
    moved, blur = np.zeros((count, 2)), np.full((count, 2), START_BLUR_PX)
    turn = np.arctan2(sides_px[..., 1], sides_px[..., 0])
    for _ in range(MOST_STEPS):
        shapes, basis = _model(offsets - moved[:, None], turn, blur, scale)
        weighted = basis * weights[..., None]
        at = np.linalg.solve(_regular(weighted.mT @ basis), weighted.mT @ levels[..., None])
        residual = levels[..., None] - basis @ at
        contrast = 2.0 * np.abs(at[:, 3, 0])
        amplitude = basis[..., :3] @ at[:, 3:]
        jacobian = np.concatenate([shapes * amplitude, basis], axis=2)
        weighted = jacobian * weights[..., None]
        step = np.linalg.solve(_regular(weighted.mT @ jacobian), weighted.mT @ residual)[..., 0]
        moved += step[:, :2].clip(-1.0, 1.0)
        turn = turn + step[:, 2:4].clip(-0.2, 0.2)
        blur = (blur + step[:, 4:6].clip(-0.5, 0.5)).clip(*BLUR_PX)
        if np.abs(step[:, :2]).max(initial=0.0) < SETTLED_PX:
            break
    side_px = np.linalg.norm(sides_px, axis=2).min(axis=1)
    misfit = np.sqrt((weights * residual[..., 0] ** 2).sum(axis=1) / weights.sum(axis=1).clip(1.0))
    sound = (
        (np.linalg.norm(moved, axis=1) < (FARTHEST_SIDES * side_px).clip(*FARTHEST_PX))
        & (np.abs(step[:, :2]).max(axis=1) < UNSETTLED_PX)
        & (blur.max(axis=1) < MOST_BLUR_SIDES * side_px)
        & (contrast > LEAST_CONTRAST)
        & (misfit < MOST_MISFIT * contrast)
    )
    return Saddles(start_px + moved, blur.max(axis=1), sound)


def _windows(
    grey: Picture, start_px: Array, sides_px: Array, arm: float, clear: float
) -> tuple[Array, Array, Array]:
    """Grey levels (n, m), offsets (n, m, 2) from the start in px, and weights (n, m) of the pixels that count."""
    sides = np.linalg.norm(sides_px, axis=2)
    arms, clears = np.minimum(arm, LONGEST_ARM_PX / sides), np.minimum(clear, WIDEST_CLEAR_PX / sides)
    half = int(np.ceil(np.max(np.sum(np.abs(sides_px) * arms[..., None], axis=1), initial=1.0)))
    rows, columns = (grid.ravel() for grid in np.mgrid[-half : half + 1, -half : half + 1])
    middle = np.rint(start_px).astype(np.int64)
    x, y = middle[:, :1] + columns, middle[:, 1:] + rows
    offsets = np.stack([x, y], axis=2) - start_px[:, None]
    along = np.abs(offsets @ np.linalg.inv(sides_px))
    height, width = grey.shape
    counts = (along <= arms[:, None]).all(axis=2) & (along <= clears[:, None]).any(axis=2)
    counts &= (x >= 0) & (y >= 0) & (x < width) & (y < height)
    # the pixels that count come first, so that the rest can be left away
    kept = np.argsort(~counts, axis=1, kind="stable")[:, : max(1, int(counts.sum(axis=1).max(initial=1)))]
    x, y = (np.take_along_axis(axis, kept, axis=1) for axis in (x, y))
    levels = grey[y.clip(0, height - 1), x.clip(0, width - 1)].astype(np.float64)
    offsets = np.take_along_axis(offsets, kept[..., None], axis=1)
    return levels, offsets, np.take_along_axis(counts, kept, axis=1).astype(np.float64)


def _model(offsets: Array, turn: Array, blur: Array, scale: float) -> tuple[Array, Array]:
    """Derivatives (n, m, 6) of the crossing by its shape, for unit amplitude, and the basis (n, m, 6) of its levels."""
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = offsets[..., :1], offsets[..., 1:]
    across, along = y * cosine - x * sine, x * cosine + y * sine
    relative = across / blur[:, None]
    edge = erf(relative / np.sqrt(2.0))
    slope = np.sqrt(2.0 / np.pi) / blur[:, None] * np.exp(-0.5 * relative**2)
    by_distance = slope * edge[..., ::-1]
    by_x, by_y = (by_distance * sine).sum(axis=2), (by_distance * -cosine).sum(axis=2)
    shapes = np.concatenate(
        [by_x[..., None], by_y[..., None], -by_distance * along, -by_distance * relative], 2
    )
    plane = np.concatenate([np.ones_like(x), offsets * scale], axis=2)
    return shapes, np.concatenate([plane, plane * edge.prod(axis=2, keepdims=True)], axis=2)


def _regular(normal: Array) -> Array:
    """Normal matrices (n, k, k) that can be solved even where a window holds nothing."""
    size = normal.shape[1]
    diagonal = np.einsum("nii->ni", normal)
    return np.asarray(normal + (1e-6 * diagonal + 1e-9)[..., None] * np.eye(size))
