"""Bundle adjustment: the cameras, poses of the board and its shape that together explain all corners best.

Levenberg-Marquardt on the corners' distances with Huber's loss. Corners weigh by the noise of their camera, which is measured
from the residuals. The board's shape is solved for with the cameras, since no print is flat and true: a board that is bent by
0.1 mm would move focal lengths by 2 px (Strobl and Hirzinger, "More accurate pinhole camera calibration with imperfect
planar target", 2011).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.corners import Array
from calibration.equations import HUBER_SIGMAS, PER_CAMERA, equations
from calibration.projection import moved, project, transformed
from calibration.rig import Observation, Prior, Rig

MOST_STEPS = 60
SETTLED = 1e-8
"""Relative gain of the cost below which a solution is one."""
LEAST_DAMPING, MOST_DAMPING = 1e-9, 1e8
NOISE_ROUNDS, SETTLED_NOISE = 4, 0.02
LEAST_NOISE_PX = 1e-4
START_NOISE_PX = 1.0


@dataclass(frozen=True, eq=False)
class Adjusted:
    """The best rig; `residual_px` (n, 2) of each observation, found minus predicted; `noise_px` (c,) of a coordinate.

    `covariance` (15 c + b, 15 c + b) is of the cameras' unknowns, then the board's: for each camera its nine intrinsics, then
    its pose's step as `moved` takes it. Rows of the first camera's pose are zero; what nothing determines has a variance
    beyond all bounds.
    """

    rig: Rig
    residual_px: tuple[Array, ...]
    noise_px: Array
    covariance: Array


def adjust(
    start: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array | None = None
) -> Adjusted:
    """The rig that explains the observations best, from a start that is near enough; `noise_px` (c,) if it is known about."""
    rig, noise_px = start, np.full(len(start.intrinsics), START_NOISE_PX) if noise_px is None else noise_px
    for _ in range(NOISE_ROUNDS):
        rig = _minimised(rig, observations, prior, noise_px)
        before_px, noise_px = noise_px, _noise(rig, observations)
        if np.allclose(before_px, noise_px, rtol=SETTLED_NOISE):
            break
    covariance = equations(rig, observations, prior, noise_px).covariance()
    return Adjusted(rig, tuple(_residuals(rig, observations)), noise_px, covariance)


def _minimised(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> Rig:
    damping, cost = 1e-4, _cost(rig, observations, prior, noise_px)
    for _ in range(MOST_STEPS):
        at = equations(rig, observations, prior, noise_px)
        while True:
            tried = _stepped(rig, *at.step(damping))
            tried_cost = _cost(tried, observations, prior, noise_px)
            if tried_cost < cost or damping > MOST_DAMPING:
                break
            damping *= 8.0
        if not tried_cost < cost * (1.0 - SETTLED):
            return tried if tried_cost < cost else rig
        rig, cost, damping = tried, tried_cost, max(damping / 6.0, LEAST_DAMPING)
    return rig


def _stepped(rig: Rig, common: Array, poses: Array) -> Rig:
    cameras = common[: PER_CAMERA * len(rig.intrinsics)].reshape(-1, PER_CAMERA)
    return Rig(
        rig.intrinsics + cameras[:, :9],
        np.array([moved(pose, step) for pose, step in zip(rig.camera_from_rig, cameras[:, 9:], strict=True)]),
        np.array([moved(pose, step) for pose, step in zip(rig.rig_from_board, poses, strict=True)]),
        rig.board.moved(common[cameras.size :]),
    )


def _residuals(rig: Rig, observations: Sequence[Observation]) -> list[Array]:
    return [
        one.px
        - project(
            rig.intrinsics[one.camera],
            transformed(rig.camera_from_rig[one.camera] @ rig.rig_from_board[one.view], rig.points_mm(one)),
        )[0]
        for one in observations
    ]


def _cost(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> float:
    """Huber's loss of all corners and the squares of what the prior says; infinite behind a camera."""
    cost = float(
        np.sum((rig.intrinsics / prior.intrinsics) ** 2) + np.sum((rig.board.amounts / prior.board) ** 2)
    )
    for one, residual_px in zip(observations, _residuals(rig, observations), strict=True):
        sigmas = np.linalg.norm(residual_px, axis=1) / noise_px[one.camera]
        near = np.minimum(sigmas, HUBER_SIGMAS)
        cost += float(np.sum(near * (2.0 * sigmas - near)))
    return cost if np.isfinite(cost) else np.inf


def _noise(rig: Rig, observations: Sequence[Observation]) -> Array:
    """The noise (c,) of a coordinate: robust, and free of what the unknowns have swallowed."""
    residuals = _residuals(rig, observations)
    found = 2 * sum(map(len, residuals))
    unknowns = PER_CAMERA * len(rig.intrinsics) - 6 + len(rig.board.amounts) + 6 * len(rig.rig_from_board)
    swallowed = max(1.0 - unknowns / found, 0.1)
    noise = np.full(len(rig.intrinsics), LEAST_NOISE_PX)
    for camera in range(len(noise)):
        own = [off for one, off in zip(observations, residuals, strict=True) if one.camera == camera]
        noise[camera] = max(LEAST_NOISE_PX, _robust_rms(np.concatenate(own)) / np.sqrt(swallowed))
    return noise


def _robust_rms(residual_px: Array) -> float:
    """The RMS (per coordinate) of a Gaussian bulk, told by a scale that outliers do not move."""
    squares = np.sum(residual_px**2, axis=1)
    bulk = squares <= 18.0 * np.median(squares) / (2.0 * np.log(2.0))
    return float(np.sqrt(np.mean(squares[bulk]) / 2.0))
