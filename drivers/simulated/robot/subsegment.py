"""The piece of rod between two disks: constant strain u = (ux, uy, uz) in 1/mm, so its motion is one exponential.

With theta = length * u and x = |theta|^2, rotation and translation over the piece are

    R(theta) = I + C [theta] + A [theta]^2         t(theta) = length * (e3 + A theta x e3 + B theta x (theta x e3))
    A = (1 - cos)/x,  B = (1 - sin/sqrt x)/x,  C = sin/sqrt x,

all smooth in x, hence evaluated as power series: no case for small angles, and derivatives cost nothing. So is
D = (1 - 2 A)/x, which the distance between the holes of two disks needs.
(Murray, Li, Sastry, "A Mathematical Introduction to Robotic Manipulation", 1994, eqs. 2.14 and 2.36.)
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_TERMS = 16  # exact to rounding up to about one full turn within a piece
_POWERS = np.arange(_TERMS)
_A, _B, _C, _FOURTH = (
    np.array([(-1.0) ** n / factorial(2 * n + shift) for n in range(_TERMS)]) for shift in (2, 3, 1, 4)
)
_D = 2 * _FOURTH


def _derivative(series: Array) -> Array:
    return np.append(series[1:] * _POWERS[1:], 0.0)


_SERIES = np.stack([_A, _B, _C, _D, _derivative(_A), _derivative(_B), _derivative(_D)])


def hat(v: Array) -> Array:
    """Cross-product matrices (..., 3, 3) of vectors (..., 3)."""
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


_E3 = np.array([0.0, 0.0, 1.0])
_IDENTITY = np.eye(3)
_HAT_E3 = hat(_E3)


@dataclass(frozen=True)
class Pieces:
    """Motion over K pieces, in the frame at each piece's base. Derivatives are taken by theta."""

    A: Array
    """(K,) as above."""
    D: Array
    A_slope: Array
    """(K,) dA/dx."""
    D_slope: Array
    rotation: Array
    """(K, 3, 3)."""
    translation: Array
    """(K, 3), mm."""
    rotation_axes: Array
    """(K, 3, 3): a change of theta turns the piece's end by rotation_axes @ change, seen in its base frame."""
    translation_slope: Array
    """(K, 3, 3), mm/rad."""


def move_along(strain_per_mm: Array, length_mm: Array) -> Array:
    """Translation in mm and tangent at the end of pieces with strain (K, 3) and length (K,), as columns of (K, 3, 2)."""
    theta = strain_per_mm * length_mm[:, None]
    A, B, C = _series(theta)[:3, :, 0]
    x, y, z = theta.T[:, :, None]
    once = np.concatenate([y, -x], axis=1)[:, :, None]
    twice = np.concatenate([x * z, y * z, -(x * x + y * y)], axis=1)[:, :, None]
    moved: Array = np.concatenate([B, A], axis=1)[:, None] * twice
    moved[:, :2] += np.concatenate([A, C], axis=1)[:, None] * once
    moved[:, 2] += 1.0
    moved[:, :, 0] *= length_mm[:, None]
    return moved


def move_with_slopes(strain_per_mm: Array, length_mm: Array) -> Pieces:
    """Motion over pieces with strain (K, 3) and length (K,), with first derivatives."""
    theta = strain_per_mm * length_mm[:, None]
    A, B, C, D, A_slope, B_slope, D_slope = _series(theta)
    cross = hat(theta)
    twice = cross @ cross
    # the translation is the last column of the same matrix that turns the piece's end: I + A [theta] + B [theta]^2
    along = _IDENTITY + A * cross + B * twice
    sideways = 2 * (A_slope * cross[:, :, 2:] + B_slope * twice[:, :, 2:]) - 2 * B * _E3[:, None]
    slope = sideways * theta[:, None, :] - A * _HAT_E3
    slope += B * (theta[:, 2, None, None] * _IDENTITY + theta[:, :, None] * _E3)
    return Pieces(
        A=A[:, 0, 0],
        D=D[:, 0, 0],
        A_slope=A_slope[:, 0, 0],
        D_slope=D_slope[:, 0, 0],
        rotation=_IDENTITY + C * cross + A * twice,
        translation=along[:, :, 2] * length_mm[:, None],
        rotation_axes=along,
        translation_slope=slope * length_mm[:, None, None],
    )


def _series(theta: Array) -> Array:
    """Every series, ready to multiply matrices: (7, K, 1, 1)."""
    powers = np.vander((theta * theta).sum(axis=1), _TERMS, increasing=True)
    values: Array = _SERIES @ powers.T
    return values[:, :, None, None]
