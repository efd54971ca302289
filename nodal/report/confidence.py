"""Regions of confidence of normally distributed errors. Pure."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

USUAL = 0.95
LEAST_VARIANCE_MM2 = 1e-12
"""A nanometre squared: a variance below that is rounding, and must not be divided by."""


def radius(confidence: float, dimensions: int) -> float:
    """How many standard deviations a region in so many dimensions reaches: the root of the chi-squared quantile."""
    from scipy.special import gammaincinv  # noqa: PLC0415  slow to import, and few commands need it

    return float(np.sqrt(2 * gammaincinv(dimensions / 2, confidence)))


def semi_axes(covariance: Array, confidence: float) -> Array:
    """The semi-axes (d, d) of the region of a covariance (d, d): one a row, the longest first."""
    variance, direction = np.linalg.eigh(covariance)
    reach = radius(confidence, len(variance)) * np.sqrt(np.maximum(variance, 0.0))
    return np.asarray((direction * reach).T[::-1])


def inside(errors_mm: Array, covariances_mm2: Array, confidence: float = USUAL) -> NDArray[np.bool_]:
    """(N,) whether errors (N, 3) lie within the ellipsoids of their covariances (N, 3, 3)."""
    variance, direction = np.linalg.eigh(covariances_mm2)
    along = np.einsum("nij,ni->nj", direction, errors_mm)
    distance = np.sqrt((along**2 / np.maximum(variance, LEAST_VARIANCE_MM2)).sum(axis=1))
    return np.asarray(distance <= radius(confidence, errors_mm.shape[1]))
