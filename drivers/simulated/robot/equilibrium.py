"""Shapes of the rod under its tendons: the energy of a strain, and the descent to a strain of least energy.

Newton's method with a line search. The unknowns are the strains of all pieces, flattened to (3K,).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.backbone import Backbone, Load, disk_frames
from drivers.simulated.robot.subsegment import Pieces, move_with_slopes
from drivers.simulated.robot.tendons import TendonPath, TendonRouting

Array = NDArray[np.float64]

_SETTLED_N_MM = 1e-8  # energy still to be gained; a few micrometres at the tip
_LARGEST_CHANGE_PER_MM = 0.03
_SHORTEST_STEP = 1e-4


@dataclass(frozen=True)
class TendonPull:
    """What the tendons do at given distances between disks."""

    energy: float
    base_N: Array
    """(T,) tension at the base."""
    tension_N: Array
    """(T, K) in every piece: the energy's derivative by distance."""
    stiffness_N_per_mm: Array
    """(T, K): how fast the tension beyond disk k rises with the length beyond disk k."""


TendonLaw = Callable[[Array], TendonPull]
"""From the distances (T, K) in mm to the pull."""


@dataclass(frozen=True)
class Pose:
    """The robot at one strain, whatever its tendons do, with its base at the origin."""

    strain: Array
    """(3K,)."""
    pieces: Pieces
    frames: Array
    """(K + 1, 3, 3) of the base and every disk."""
    points_mm: Array
    """(K + 1, 3)."""
    load: Load
    path: TendonPath


@dataclass(frozen=True)
class Balance:
    """A pose and the forces in it."""

    pose: Pose
    pull: TendonPull
    energy: float
    gradient: Array
    """(3K,)."""


@dataclass(frozen=True)
class Mechanics:
    """A backbone and the tendons along it."""

    backbone: Backbone
    routing: TendonRouting

    def pose(self, strain: Array) -> Pose:
        """The robot at strain (3K,)."""
        by_piece = strain.reshape(-1, 3)
        pieces = move_with_slopes(by_piece, self.backbone.piece_length_mm)
        frames, points_mm = disk_frames(pieces)
        return Pose(
            strain=strain,
            pieces=pieces,
            frames=frames,
            points_mm=points_mm,
            load=self.backbone.load(pieces, frames, points_mm),
            path=self.routing.path(by_piece, pieces),
        )

    def balance(self, pose: Pose, law: TendonLaw) -> Balance:
        """Energy and forces in a pose with the tendons under `law`."""
        pull = law(pose.path.distance_mm)
        flexed = pose.strain - self.backbone.rest_strain_per_mm
        elastic = self.backbone.stiffness_N_mm * flexed
        tendons = (pull.tension_N[:, :, None] * pose.path.slope_mm2).sum(axis=0).ravel()
        energy = float(elastic @ flexed) / 2 + pose.load.energy + pull.energy
        return Balance(pose, pull, energy, elastic + pose.load.gradient + tendons)

    def hessian(self, at: Balance) -> Array:
        """Second derivative (3K, 3K) of the energy, for Newton steps: small terms are left out."""
        path, pull = at.pose.path, at.pull
        # with piece k at or before piece l, a tendon couples their strains by what resists length beyond piece k
        resisting = np.cumsum(pull.stiffness_N_per_mm, axis=1)[:, :, None] * path.slope_mm2
        tendons, pieces, _ = resisting.shape
        upper = resisting.reshape(tendons, -1).T @ path.slope_mm2.reshape(tendons, -1)
        upper += at.pose.load.second_derivative()
        piece = np.arange(pieces)
        blocks = upper.reshape(pieces, 3, pieces, 3)
        blocks[piece, :, piece, :] += self.routing.geometric_stiffness(path, at.pose.pieces, pull.tension_N)
        hessian = np.where(_upper_triangle(len(upper)), upper, upper.T)
        hessian.flat[:: len(hessian) + 1] += self.backbone.stiffness_N_mm
        return hessian

    def descend(self, start: Pose, law: TendonLaw, max_steps: int) -> tuple[Balance, bool]:
        """Follow Newton's direction from a pose for at most `max_steps`; also says whether it settled."""
        here = self.balance(start, law)
        for _ in range(max_steps):
            # tendons only stiffen the rod, so that the rod alone tells what energy may still be gained
            if float(here.gradient**2 @ (1 / self.backbone.stiffness_N_mm)) < _SETTLED_N_MM:
                return here, True
            direction = self._downhill(here)
            slope = float(here.gradient @ direction)
            step = min(1.0, _LARGEST_CHANGE_PER_MM / float(np.abs(direction).max()))
            there = self.balance(self.pose(here.pose.strain + step * direction), law)
            while there.energy > here.energy + 1e-3 * step * slope:
                step /= 4
                if step < _SHORTEST_STEP:
                    return here, False
                there = self.balance(self.pose(here.pose.strain + step * direction), law)
            here = there
        return here, False

    def _downhill(self, at: Balance) -> Array:
        """Newton's direction, the backbone stiffened until it leads downhill."""
        hessian = self.hessian(at)
        stiffening = 0.1
        while True:
            direction = np.asarray(-np.linalg.solve(hessian, at.gradient), dtype=np.float64)
            if at.gradient @ direction < 0:
                return direction
            hessian += stiffening * np.diag(self.backbone.stiffness_N_mm)
            stiffening *= 4


@cache
def _upper_triangle(size: int) -> NDArray[np.bool_]:
    return np.triu(np.ones((size, size), dtype=bool))
