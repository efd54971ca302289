"""The backbone: a chain of K pieces between disks, with bending and torsional stiffness, rest strain and forces on them.

The unknown is the strain of every piece, (K, 3) in 1/mm: curvature about the local x and y axes and twist. The rod is
inextensible and does not shear (Kirchhoff). Energies are in N mm, of a base that stands upright at the origin.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings
from drivers.simulated.robot.subsegment import Pieces

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Load:
    """What forces on the disks do to the rod in one configuration."""

    energy: float
    gradient: Array
    """(3K,)."""
    axes: Array
    """(K, 3, 3) axes, in the base frame, about which each strain turns everything beyond its piece, as columns."""
    lever_N_mm: Array
    """(K, 3, 3) sum of lever times force, (3,) each, beyond the middle of each piece."""

    def second_derivative(self) -> Array:
        """(3K, 3K); valid in its upper triangle, where the row's strain lies nearer to the base.

        Two turns a, then b nearer to the tip, move a force F at lever r from b by F . (a x (b x r)).
        """
        inner = np.einsum("kii->k", self.lever_N_mm)[:, None, None] * self.axes - self.lever_N_mm @ self.axes
        derivative: Array = _columns(self.axes).T @ _columns(inner)
        return derivative


@dataclass(frozen=True)
class Backbone:
    piece_length_mm: Array
    """(K,)."""
    piece_section: NDArray[np.intp]
    """(K,) index of the section that a piece belongs to."""
    stiffness_N_mm: Array
    """(3K,) energy per squared strain, twice: E I length for bending, G J length for twist."""
    rest_strain_per_mm: Array
    """(3K,)."""
    disk_force_N: Array
    """(K, 3) force on the disk at the end of each piece, in the base frame: weight, and what else pushes."""

    def slowed(self, strain: Array, retardation: float) -> "Backbone":
        """The backbone that stands for this one with a viscous pull towards `strain`, `retardation` times as stiff."""
        return replace(
            self,
            stiffness_N_mm=self.stiffness_N_mm * (1 + retardation),
            rest_strain_per_mm=(self.rest_strain_per_mm + retardation * strain) / (1 + retardation),
        )

    def load(self, pieces: Pieces, frames: Array, points_mm: Array) -> Load:
        """The forces' share, for frames (K + 1, 3, 3) and centres (K + 1, 3) of the base and every disk."""
        force, ends_mm = self.disk_force_N, points_mm[1:]
        beyond = np.empty((len(force), 4, 3))
        beyond[:, 0] = force
        beyond[:, 1:] = ends_mm[:, :, None] * force[:, None]
        beyond = beyond[::-1].cumsum(axis=0)[::-1]
        push = beyond[:, :1]
        lever = beyond[:, 1:] - ends_mm[:, :, None] * push
        moment = lever[:, (1, 2, 0), (2, 0, 1)] - lever[:, (2, 0, 1), (1, 2, 0)]
        axes = (frames[:-1] @ pieces.rotation_axes) * self.piece_length_mm[:, None, None]
        shift = (push @ frames[:-1] @ pieces.translation_slope)[:, 0] * self.piece_length_mm[:, None]
        return Load(
            energy=-float((force * ends_mm).sum()),
            gradient=-(shift + (moment[:, None] @ axes)[:, 0]).ravel(),
            axes=axes,
            lever_N_mm=lever + (ends_mm - points_mm[:-1])[:, :, None] / 2 * push,
        )


def build_backbone(settings: SimulatedRobotSettings) -> Backbone:
    """The chain of pieces of all sections, from base to tip."""
    gravity_N_per_g = settings.gravity_m_s2 * 1e-3
    weight = [_disk_weight_g(section, settings) * gravity_N_per_g for section in settings.sections]
    weight[-1][-1] += settings.tip_payload_g * gravity_N_per_g
    counts = [piece_count(section) for section in settings.sections]
    return Backbone(
        piece_length_mm=np.concatenate(
            [np.full(n, s.length_mm / n) for n, s in zip(counts, settings.sections, strict=True)]
        ),
        piece_section=np.repeat(np.arange(len(counts)), counts),
        stiffness_N_mm=np.concatenate([_stiffness(section).ravel() for section in settings.sections]),
        rest_strain_per_mm=np.concatenate([_rest_strain(section).ravel() for section in settings.sections]),
        disk_force_N=np.concatenate(weight)[:, None] * [0.0, 0.0, -1.0],
    )


def piece_count(section: SectionSettings) -> int:
    """Number of pieces of a section: its length in whole disk spacings."""
    return max(1, round(section.length_mm / section.disk_spacing_mm))


def disk_frames(pieces: Pieces) -> tuple[Array, Array]:
    """Frames (K + 1, 3, 3) and centres (K + 1, 3) in mm of the base and of every disk, with the base at the origin."""
    count = len(pieces.rotation)
    frames = np.concatenate([np.eye(3)[None], pieces.rotation])
    span = 1
    while (
        span <= count
    ):  # products of neighbours, then of neighbouring pairs, ...: a scan without a loop over pieces
        frames[span:] = frames[:-span] @ frames[span:]
        span *= 2
    points = np.zeros((count + 1, 3))
    np.cumsum((frames[:-1] @ pieces.translation[:, :, None])[:, :, 0], axis=0, out=points[1:])
    return frames, points


def _columns(by_piece: Array) -> Array:
    """(3, 3K) the columns of (K, 3, 3), side by side."""
    return by_piece.transpose(1, 0, 2).reshape(3, -1)


def _piece_middles(section: SectionSettings) -> Array:
    """(n,) position of each piece's middle along its section, 0 at the base and 1 at the tip."""
    count = piece_count(section)
    return (np.arange(count) + 0.5) / count


def _stiffness(section: SectionSettings) -> Array:
    length_mm = section.length_mm / piece_count(section)
    bending_N_mm2 = section.youngs_modulus_GPa * 1e3 * np.pi / 4 * section.backbone_radius_mm**4
    torsion_N_mm2 = bending_N_mm2 / (1 + section.poisson_ratio)
    taper = 1 + section.stiffness_variation * (1 - 2 * _piece_middles(section))
    return length_mm * taper[:, None] * [bending_N_mm2, bending_N_mm2, torsion_N_mm2]


def _rest_strain(section: SectionSettings) -> Array:
    # bending towards +X is a turn about +Y, bending towards +Y a turn about -X
    toward_x, toward_y = section.precurvature_per_mm
    return (1 - _piece_middles(section))[:, None] * [-toward_y, toward_x, 0.0]


def _disk_weight_g(section: SectionSettings, settings: SimulatedRobotSettings) -> Array:
    count = piece_count(section)
    rod_mm3 = np.pi * section.backbone_radius_mm**2 * section.length_mm / count
    return np.full(count, settings.disk_mass_g + settings.backbone_density_g_cm3 * 1e-3 * rod_mm3)
