"""Play and friction where an axis turns round: the motion that is lost, and how to make up for it. Pure.

An axis stands somewhere in its lost motion, from -1 (last moved back) to 1 (last moved on), and what the robot feels lags
behind by that share of half of the lost motion: a play operator (Krejci, Kuhnen, "Inverse control of systems with hysteresis
and creep", 2001) that engages over `engaging_mm` of felt motion instead of at once. Its inverse moves the axis further by
what is being lost.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def felt_mm(position_mm: Array, engaged: Array, width_mm: Array) -> Array:
    """(A,) what the robot feels of axes at `position_mm` (A,) with a lost motion of `width_mm` (A,)."""
    return position_mm - engaged * width_mm / 2


def engaged_after(engaged: Array, moved_mm: Array, width_mm: Array, engaging_mm: float) -> Array:
    """(A,) where axes stand in their lost motion after they moved by `moved_mm` (A,)."""
    after: Array = np.minimum(np.maximum(engaged + moved_mm / (width_mm / 2 + engaging_mm), -1.0), 1.0)
    return after


def motion_for(felt: Array, engaged: Array, width_mm: Array, engaging_mm: float) -> Array:
    """(A,) how far axes must move, from where they stand in their lost motion, for the robot to feel `felt` mm (A,) of it."""
    until_engaged = (np.sign(felt) - engaged) * engaging_mm
    engaging = np.where(np.abs(felt) < np.abs(until_engaged), felt, until_engaged)
    motion: Array = felt + engaging * width_mm / 2 / engaging_mm
    return motion


def stretch(engaged: Array, width_mm: Array, engaging_mm: float) -> tuple[Array, Array]:
    """How many mm an axis moves (A,) for each that is felt: on its way back, and on its way on."""
    engaging = 1.0 + width_mm / 2 / engaging_mm
    return np.where(engaged > -1.0, engaging, 1.0), np.where(engaged < 1.0, engaging, 1.0)
