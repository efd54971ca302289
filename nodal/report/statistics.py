"""Figures of many values; None where there are none to make them of."""

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 4


def rounded(value: ArrayLike | None) -> float | None:
    """To the digits that are worth writing down."""
    return None if value is None else round(float(np.asarray(value)), DIGITS)


def mean(values: ArrayLike) -> float | None:
    """Of any number of values."""
    values = np.asarray(values)
    return rounded(values.mean()) if values.size else None


def rms(values: ArrayLike) -> float | None:
    """Root of the mean square."""
    values = np.asarray(values)
    return rounded(np.sqrt((values**2).mean())) if values.size else None


def least(values: ArrayLike) -> float | None:
    """The smallest."""
    values = np.asarray(values)
    return rounded(values.min()) if values.size else None


def most(values: ArrayLike) -> float | None:
    """The largest."""
    values = np.asarray(values)
    return rounded(values.max()) if values.size else None


def percentile(values: ArrayLike, share: float) -> float | None:
    """Below which `share` per cent of the values lie."""
    values = np.asarray(values)
    return rounded(np.percentile(values, share)) if values.size else None
