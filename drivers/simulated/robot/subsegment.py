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


_SERIES = np.stack([_A, _B, _C, _D, _derivative(_A), _derivative(_B), _derivative(_D)], axis=1)
_E3 = np.array([0.0, 0.0, 1.0])
_IDENTITY = np.eye(3)


def hat(v: Array) -> Array:
    """Cross-product matrices (..., 3, 3) of vectors (..., 3)."""
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


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


def move_along(strain_per_mm: Array, length_mm: Array) -> tuple[Array, Array]:
    """Rotation (K, 3, 3) and translation (K, 3) over pieces with strain (K, 3) and length (K,)."""
    theta = strain_per_mm * length_mm[:, None]
    A, B, C, *_ = _series(theta)
    return _rotation(theta, A, C), _translation(theta, A, B) * length_mm[:, None]


def move_with_slopes(strain_per_mm: Array, length_mm: Array) -> Pieces:
    """As `move_along`, with first derivatives."""
    theta = strain_per_mm * length_mm[:, None]
    A, B, C, D, A_slope, B_slope, D_slope = _series(theta)
    cross = hat(theta)
    once = cross @ _E3
    twice = (cross @ once[:, :, None])[:, :, 0]
    twice_slope = (
        theta[:, 2, None, None] * _IDENTITY + theta[:, :, None] * _E3 - 2 * _E3[:, None] * theta[:, None, :]
    )
    slope = 2 * (A_slope[:, None] * once + B_slope[:, None] * twice)[:, :, None] * theta[:, None, :]
    slope += B[:, None, None] * twice_slope
    slope -= A[:, None, None] * hat(_E3)
    return Pieces(
        A=A,
        D=D,
        A_slope=A_slope,
        D_slope=D_slope,
        rotation=_rotation(theta, A, C),
        translation=_translation(theta, A, B) * length_mm[:, None],
        rotation_axes=_IDENTITY + A[:, None, None] * cross + B[:, None, None] * (cross @ cross),
        translation_slope=slope * length_mm[:, None, None],
    )


def _series(theta: Array) -> Array:
    squared = np.einsum("ki,ki->k", theta, theta)
    return (squared[:, None] ** _POWERS @ _SERIES).T


def _rotation(theta: Array, A: Array, C: Array) -> Array:
    cross = hat(theta)
    return _IDENTITY + C[:, None, None] * cross + A[:, None, None] * (cross @ cross)


def _translation(theta: Array, A: Array, B: Array) -> Array:
    """Per length: e3 + A theta x e3 + B theta x (theta x e3)."""
    x, y, z = theta.T
    return np.stack([A * y + B * x * z, -A * x + B * y * z, 1.0 - B * (x * x + y * y)], axis=1)
