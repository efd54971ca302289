"""Bundle adjustment: cameras and poses of the board that together explain all corners best.

Levenberg-Marquardt on the corners' distances with Huber's loss; the poses of the views are eliminated from the normal equations
(Schur complement; Triggs et al., "Bundle adjustment: a modern synthesis", 2000, section 6.1), so that what is solved is as
small as the cameras are few. Corners weigh by the noise of their camera, which is measured from the residuals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array
from calibration.projection import by_pose, moved, project, transformed

MOST_STEPS = 60
SETTLED = 1e-8
"""Relative gain of the cost below which a solution is one."""
HUBER_SIGMAS = 3.0
NOISE_ROUNDS, SETTLED_NOISE = 4, 0.02
LEAST_NOISE_PX = 1e-4
START_NOISE_PX = 1.0
LEAST_DAMPING, MOST_DAMPING = 1e-9, 1e8
TINY, SMALLEST_EIGENVALUE = 1e-12, 1e-14
PER_CAMERA = 15
"""Unknowns of a camera: nine intrinsics, six of its pose in the rig."""


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
    """A solution: `intrinsics` (c, 9), `camera_from_rig` (c, 4, 4) and `rig_from_board` (v, 4, 4), mm.

    The first camera's `camera_from_rig` stays what it is.
    """

    intrinsics: Array
    camera_from_rig: Array
    rig_from_board: Array


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of any camera before it is seen: `mean` (9,) and `sigma` (9,) of its intrinsics, infinite if nothing."""

    mean: Array
    sigma: Array

    @property
    def precision(self) -> Array:
        """(9,): one over the variance."""
        return np.asarray(self.sigma**-2.0)


@dataclass(frozen=True, eq=False)
class Adjusted:
    """The best rig; `residual_px` (n, 2) of each observation, found minus predicted; `noise_px` (c,) of a coordinate.

    `covariance` (15 c, 15 c) is of the cameras' unknowns: for each its nine intrinsics, then its pose's step as `moved` takes
    it. Rows of the first camera's pose are zero; what nothing determines has a variance beyond all bounds.
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
    system = _system(rig, observations, prior, noise_px)
    covariance = np.zeros_like(system.cameras)
    covariance[np.ix_(system.free, system.free)] = _inverse(system.reduced(0.0)[0])
    return Adjusted(rig, tuple(_residuals(rig, observations)), noise_px, covariance)


@dataclass(frozen=True, eq=False)
class _System:
    """Normal equations of a rig: of the cameras (15 c), of the views (v, 6), and between both (v, 15 c, 6)."""

    cameras: Array
    camera_slope: Array
    views: Array
    view_slope: Array
    between: Array

    @property
    def free(self) -> NDArray[np.int64]:
        """The cameras' unknowns without the first one's pose."""
        return np.delete(np.arange(len(self.cameras)), np.s_[9:PER_CAMERA])

    def reduced(self, damping: float) -> tuple[Array, Array]:
        """The equations (k, k) and (k,) of the free unknowns when the views' are eliminated."""
        damped = _damped(self.views, damping)
        eliminated = np.linalg.solve(damped, self.between.mT)
        left = _damped(self.cameras, damping) - np.einsum("vij,vjk->ik", self.between, eliminated)
        right = self.camera_slope - np.einsum("vji,vj->i", eliminated, self.view_slope)
        return left[np.ix_(self.free, self.free)], right[self.free]

    def step(self, damping: float) -> tuple[Array, Array]:
        """Steps (c, 15) of the cameras and (v, 6) of the views."""
        cameras = np.zeros(len(self.cameras))
        cameras[self.free] = np.linalg.solve(*self.reduced(damping))
        right = self.view_slope - np.einsum("vij,i->vj", self.between, cameras)
        views = np.linalg.solve(_damped(self.views, damping), right[..., None])[..., 0]
        return cameras.reshape(-1, PER_CAMERA), views


def _minimised(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> Rig:
    damping, cost = 1e-4, _cost(rig, observations, prior, noise_px)
    for _ in range(MOST_STEPS):
        system = _system(rig, observations, prior, noise_px)
        while True:
            tried = _stepped(rig, *system.step(damping))
            tried_cost = _cost(tried, observations, prior, noise_px)
            if tried_cost < cost or damping > MOST_DAMPING:
                break
            damping *= 8.0
        if not tried_cost < cost * (1.0 - SETTLED):
            return tried if tried_cost < cost else rig
        rig, cost, damping = tried, tried_cost, max(damping / 6.0, LEAST_DAMPING)
    return rig


def _stepped(rig: Rig, cameras: Array, views: Array) -> Rig:
    return Rig(
        rig.intrinsics + cameras[:, :9],
        np.array([moved(pose, step) for pose, step in zip(rig.camera_from_rig, cameras[:, 9:], strict=True)]),
        np.array([moved(pose, step) for pose, step in zip(rig.rig_from_board, views, strict=True)]),
    )


def _residuals(rig: Rig, observations: Sequence[Observation]) -> list[Array]:
    return [
        one.px
        - project(
            rig.intrinsics[one.camera],
            transformed(rig.camera_from_rig[one.camera] @ rig.rig_from_board[one.view], one.points_mm),
        )[0]
        for one in observations
    ]


def _cost(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> float:
    """Huber's loss of all corners and the squares of what the prior says; infinite behind a camera."""
    away = rig.intrinsics - prior.mean
    cost = float(np.sum(prior.precision * away**2))
    for one, residual_px in zip(observations, _residuals(rig, observations), strict=True):
        sigmas = np.linalg.norm(residual_px, axis=1) / noise_px[one.camera]
        near = np.minimum(sigmas, HUBER_SIGMAS)
        cost += float(np.sum(near * (2.0 * sigmas - near)))
    return cost if np.isfinite(cost) else np.inf


def _system(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> _System:
    unknowns, shown = PER_CAMERA * len(rig.intrinsics), len(rig.rig_from_board)
    system = _System(
        cameras=np.zeros((unknowns, unknowns)),
        camera_slope=np.zeros(unknowns),
        views=np.zeros((shown, 6, 6)),
        view_slope=np.zeros((shown, 6)),
        between=np.zeros((shown, unknowns, 6)),
    )
    for camera, intrinsics in enumerate(rig.intrinsics):
        own = np.arange(9) + PER_CAMERA * camera
        system.cameras[own, own] += prior.precision
        system.camera_slope[own] += prior.precision * (prior.mean - intrinsics)
    for one in observations:
        camera_from_rig, rig_from_board = rig.camera_from_rig[one.camera], rig.rig_from_board[one.view]
        points_mm = transformed(rig_from_board, one.points_mm)
        px, by_point, by_intrinsics = project(
            rig.intrinsics[one.camera], transformed(camera_from_rig, points_mm)
        )
        by_camera = np.concatenate([by_intrinsics, by_point @ by_pose(camera_from_rig, points_mm)], axis=2)
        by_view = by_point @ camera_from_rig[:3, :3] @ by_pose(rig_from_board, one.points_mm)
        sigmas = (one.px - px) / noise_px[one.camera]
        weight = np.sqrt(_huber_weights(sigmas)) / noise_px[one.camera]
        right = (one.px - px) * weight[:, None]
        by_camera = (by_camera * weight[:, None, None]).reshape(-1, PER_CAMERA)
        by_view = (by_view * weight[:, None, None]).reshape(-1, 6)
        block = slice(PER_CAMERA * one.camera, PER_CAMERA * (one.camera + 1))
        system.cameras[block, block] += by_camera.T @ by_camera
        system.camera_slope[block] += by_camera.T @ right.ravel()
        system.views[one.view] += by_view.T @ by_view
        system.view_slope[one.view] += by_view.T @ right.ravel()
        system.between[one.view, block] += by_camera.T @ by_view
    return system


def _huber_weights(sigmas: Array) -> Array:
    """Weights (n,) of residuals (n, 2)."""
    return np.asarray(HUBER_SIGMAS / np.maximum(np.linalg.norm(sigmas, axis=1), HUBER_SIGMAS))


def _noise(rig: Rig, observations: Sequence[Observation]) -> Array:
    """The noise (c,) of a coordinate: robust, and free of what the unknowns have swallowed."""
    residuals = _residuals(rig, observations)
    found = 2 * sum(map(len, residuals))
    unknowns = PER_CAMERA * len(rig.intrinsics) - 6 + 6 * len(rig.rig_from_board)
    swallowed = max(1.0 - unknowns / found, 0.1)
    noise = np.full(len(rig.intrinsics), LEAST_NOISE_PX)
    for camera in range(len(noise)):
        own = np.concatenate(
            [r for one, r in zip(observations, residuals, strict=True) if one.camera == camera]
        )
        noise[camera] = max(LEAST_NOISE_PX, _robust_rms(own) / np.sqrt(swallowed))
    return noise


def _robust_rms(residual_px: Array) -> float:
    """The RMS (per coordinate) of a Gaussian bulk, told by a scale that outliers do not move."""
    squares = np.sum(residual_px**2, axis=1)
    bulk = squares <= 18.0 * np.median(squares) / (2.0 * np.log(2.0))
    return float(np.sqrt(np.mean(squares[bulk]) / 2.0))


def _damped(normal: Array, damping: float) -> Array:
    """Normal matrices (..., k, k) with Marquardt's damping, and never quite singular."""
    diagonal = np.einsum("...ii->...i", normal)
    return np.asarray(normal + (damping * diagonal + TINY)[..., None] * np.eye(normal.shape[-1]))


def _inverse(normal: Array) -> Array:
    """The inverse of a symmetric matrix (k, k) whose unknowns have very different units, even where it is singular."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), TINY))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    inverse = (vectors / np.maximum(values, SMALLEST_EIGENVALUE)) @ vectors.T
    return np.asarray(inverse * np.outer(scale, scale))
