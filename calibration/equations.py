"""The normal equations of bundle adjustment, from which the poses of the views are eliminated (Schur complement).

Triggs et al., "Bundle adjustment: a modern synthesis" (2000), section 6.1. What is left to be solved is as small as the cameras
are few. Huber's loss is minimised by weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.corners import Array
from calibration.projection import by_pose, project, transformed
from calibration.rig import Observation, Prior, Rig

HUBER_SIGMAS = 3.0
PER_CAMERA = 15
"""Unknowns of a camera: nine intrinsics, six of its pose in the rig."""
TINY, SMALLEST_EIGENVALUE = 1e-12, 1e-14


@dataclass(frozen=True, eq=False)
class Equations:
    """Those of a rig whose views have v poses; k unknowns are all views' own: the cameras' (15 c), then the board's.

    Each view says `common` (v, k, k) and `common_slope` (v, k) of these, `poses` (v, 6, 6) and `pose_slope` (v, 6) of its pose,
    and `between` (v, k, 6) of both; the prior says `known` (k,) and `known_slope` (k,).
    """

    common: Array
    common_slope: Array
    poses: Array
    pose_slope: Array
    between: Array
    known: Array
    known_slope: Array

    @property
    def free(self) -> NDArray[np.int64]:
        """The common unknowns without the first camera's pose, which is where the rig is."""
        return np.delete(np.arange(len(self.known)), np.s_[9:PER_CAMERA])

    def step(self, damping: float) -> tuple[Array, Array]:
        """Steps (k,) of the common unknowns and (v, 6) of the poses, with Marquardt's damping."""
        poses = _damped(self.poses, damping)
        eliminated = np.linalg.solve(poses, self.between.mT)
        left = _damped(self.common.sum(axis=0) + np.diag(self.known), damping)
        left -= np.einsum("vij,vjk->ik", self.between, eliminated)
        right = self.common_slope.sum(axis=0) + self.known_slope
        right -= np.einsum("vji,vj->i", eliminated, self.pose_slope)
        common = np.zeros(len(self.known))
        common[self.free] = np.linalg.solve(left[np.ix_(self.free, self.free)], right[self.free])
        rest = self.pose_slope - np.einsum("vij,i->vj", self.between, common)
        return common, np.linalg.solve(poses, rest[..., None])[..., 0]

    def covariance(self) -> Array:
        """Of the common unknowns (k, k), zero for those that are not free.

        Views may disagree by more than their corners' noise: a bent board, the camera's own processing. Errors are then alike
        within a view, and what many corners say is worth less than their number. The sum of squares of what each view alone would
        change says by how much, beside what it would be with independent errors; all variances grow by that factor.
        """
        eliminated = np.linalg.solve(_damped(self.poses, 0.0), self.between.mT)
        said = (self.common - self.between @ eliminated)[:, self.free[:, None], self.free]
        pulls = (self.common_slope - np.einsum("vji,vj->vi", eliminated, self.pose_slope))[:, self.free]
        inverse = _inverse(said.sum(axis=0) + np.diag(self.known[self.free]))
        shares = inverse @ said
        expected = np.trace(shares.sum(axis=0)) - np.einsum("vij,vji->", shares, shares)
        found = np.einsum("vi,ij,vj->", pulls, inverse, pulls)
        covariance = np.zeros((len(self.known), len(self.known)))
        covariance[np.ix_(self.free, self.free)] = inverse * max(1.0, found / max(expected, 1.0))
        return covariance


def equations(rig: Rig, observations: Sequence[Observation], prior: Prior, noise_px: Array) -> Equations:
    """The equations at a rig, for corners as exact as `noise_px` (c,) of their camera."""
    cameras = PER_CAMERA * len(rig.intrinsics)
    unknowns, views = cameras + len(rig.board.amounts), len(rig.rig_from_board)
    values = np.zeros(unknowns)
    values[:cameras].reshape(-1, PER_CAMERA)[:, :9] = rig.intrinsics
    values[cameras:] = rig.board.amounts
    known = np.zeros(unknowns)
    known[:cameras].reshape(-1, PER_CAMERA)[:, :9] = prior.intrinsics**-2.0
    known[cameras:] = prior.board**-2.0
    result = Equations(
        common=np.zeros((views, unknowns, unknowns)),
        common_slope=np.zeros((views, unknowns)),
        poses=np.zeros((views, 6, 6)),
        pose_slope=np.zeros((views, 6)),
        between=np.zeros((views, unknowns, 6)),
        known=known,
        known_slope=-known * values,
    )
    for one in observations:
        own = np.arange(PER_CAMERA * one.camera, PER_CAMERA * (one.camera + 1))
        block = np.concatenate([own, np.arange(cameras, unknowns)])
        off, by_common, by_view = _linearised(rig, one, float(noise_px[one.camera]))
        result.common[one.view][np.ix_(block, block)] += by_common.T @ by_common
        result.common_slope[one.view, block] += by_common.T @ off
        result.poses[one.view] += by_view.T @ by_view
        result.pose_slope[one.view] += by_view.T @ off
        result.between[one.view, block] += by_common.T @ by_view
    return result


def _linearised(rig: Rig, one: Observation, noise_px: float) -> tuple[Array, Array, Array]:
    """Weighted: how far corners are off (2 n,), and derivatives by camera and board (2 n, 15 + b) and by pose (2 n, 6)."""
    camera_from_rig, rig_from_board = rig.camera_from_rig[one.camera], rig.rig_from_board[one.view]
    on_board_mm = rig.points_mm(one)
    at_rig_mm = transformed(rig_from_board, on_board_mm)
    px, by_point, by_intrinsics = project(rig.intrinsics[one.camera], transformed(camera_from_rig, at_rig_mm))
    by_rig_point = by_point @ camera_from_rig[:3, :3]
    by_common = [by_intrinsics, by_point @ by_pose(camera_from_rig, at_rig_mm)]
    if len(rig.board.amounts):
        by_common.append(by_rig_point @ rig_from_board[:3, :3] @ rig.board.modes[one.ids])
    off_px = one.px - px
    weight = np.sqrt(huber_weights(off_px / noise_px))[:, None, None] / noise_px
    return (
        (off_px[..., None] * weight).ravel(),
        (np.concatenate(by_common, axis=2) * weight).reshape(off_px.size, -1),
        (by_rig_point @ by_pose(rig_from_board, on_board_mm) * weight).reshape(off_px.size, 6),
    )


def huber_weights(sigmas: Array) -> Array:
    """Weights (n,) of residuals (n, 2), in standard deviations."""
    return np.asarray(HUBER_SIGMAS / np.maximum(np.linalg.norm(sigmas, axis=1), HUBER_SIGMAS))


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
