"""Products of many vectors at once and their like, several times as fast as NumPy's own for a few hundred of them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray


def inner(first: FloatArray, second: FloatArray) -> FloatArray:
    """Inner products (..., 1) of vectors (..., n)."""
    return np.asarray(np.einsum("...i,...i->...", first, second)[..., None])


def lengths(vectors: FloatArray) -> FloatArray:
    """Lengths (..., 1) of vectors (..., n)."""
    return np.asarray(np.sqrt(inner(vectors, vectors)))


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products (..., 3) of vectors (..., 3) of one shape, or of shapes that broadcast."""
    product = np.empty(np.broadcast_shapes(first.shape, second.shape))
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        product[..., axis] = first[..., one] * second[..., other] - first[..., other] * second[..., one]
    return product


def median(values: NDArray[np.floating[Any]]) -> FloatArray:
    """The upper median (...) of values (..., n), n > 0: one of the values, which for many is the median."""
    return np.asarray(np.sort(values, axis=-1)[..., values.shape[-1] // 2])
