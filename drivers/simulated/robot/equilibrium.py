"""Shapes of the rod under its tendons: the energy of a strain, and the descent to a strain of least energy.

Newton's method with a line search. The unknowns are the strains of all pieces, flattened to (3K,).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.backbone import Backbone, Term, disk_frames
from drivers.simulated.robot.subsegment import Pieces, move_with_slopes
from drivers.simulated.robot.tendons import TendonPath, TendonRouting

Array = NDArray[np.float64]

_SETTLED_N_MM = 1e-9  # energy still to be gained; about a micrometre at the tip
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
class Configuration:
    """The robot at one strain, with its base at the origin."""

    strain: Array
    """(3K,)."""
    pieces: Pieces
    frames: Array
    """(K + 1, 3, 3) of the base and every disk."""
    points_mm: Array
    """(K + 1, 3)."""
    path: TendonPath
    pull: TendonPull
    energy: Term
    settled: bool = False


@dataclass(frozen=True)
class Mechanics:
    """A backbone and the tendons along it."""

    backbone: Backbone
    routing: TendonRouting

    def configuration(self, strain: Array, law: TendonLaw) -> Configuration:
        """The robot at strain (3K,), with the tendons under `law`."""
        by_piece = strain.reshape(-1, 3)
        pieces = move_with_slopes(by_piece, self.backbone.piece_length_mm)
        frames, points_mm = disk_frames(pieces)
        path = self.routing.path(by_piece, pieces)
        pull = law(path.distance_mm)
        shares = (
            self.backbone.elastic_energy(strain),
            self.backbone.weight_energy(pieces, frames, points_mm),
            self._tendon_energy(path, pieces, pull),
        )
        total = Term(
            sum(share.energy for share in shares),
            sum((share.gradient for share in shares), np.zeros_like(strain)),
            sum((share.hessian for share in shares), np.zeros((strain.size, strain.size))),
        )
        return Configuration(strain, pieces, frames, points_mm, path, pull, total)

    def descend(self, start: Array, law: TendonLaw, max_steps: int) -> Configuration:
        """Follow Newton's direction from strain (3K,) until no energy is to be gained, or for `max_steps` steps."""
        here = self.configuration(start, law)
        for _ in range(max_steps):
            direction = self._downhill(here.energy)
            gain = -float(here.energy.gradient @ direction)
            if gain < _SETTLED_N_MM:
                return _as_settled(here)
            step = min(1.0, _LARGEST_CHANGE_PER_MM / float(np.abs(direction).max()))
            there = self.configuration(here.strain + step * direction, law)
            while there.energy.energy > here.energy.energy - 1e-3 * step * gain:
                step /= 4
                if step < _SHORTEST_STEP:
                    return here
                there = self.configuration(here.strain + step * direction, law)
            here = there
        return here

    def _downhill(self, energy: Term) -> Array:
        """Newton's direction, stiffened by multiples of the backbone until it leads downhill."""
        extra = 0.0
        while True:
            hessian = energy.hessian + extra * np.diag(self.backbone.stiffness_N_mm)
            if _is_positive(hessian):
                return -np.linalg.solve(hessian, energy.gradient)
            extra = max(0.1, 4 * extra)

    def _tendon_energy(self, path: TendonPath, pieces: Pieces, pull: TendonPull) -> Term:
        slope = path.slope_mm2
        count = slope.shape[1]
        gradient = np.einsum("tk,tki->ki", pull.tension_N, slope).ravel()
        # derivative of every length beyond a disk by every strain
        beyond = (np.triu(np.ones((count, count)))[:, :, None] * slope[:, None]).reshape(-1, 3 * count)
        hessian = (beyond * pull.stiffness_N_per_mm.reshape(-1, 1)).T @ beyond
        blocks = self.routing.geometric_stiffness(path, pieces, pull.tension_N)
        diagonal = np.arange(count)
        hessian.reshape(count, 3, count, 3)[diagonal, :, diagonal, :] += blocks
        return Term(pull.energy, gradient, hessian)


def _is_positive(matrix: Array) -> bool:
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def _as_settled(configuration: Configuration) -> Configuration:
    return replace(configuration, settled=True)
