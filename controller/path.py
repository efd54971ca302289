"""A target's path between its moments: smooth, and never beyond what its positions say. Pure.

Cubic Hermite pieces with the slopes of Fritsch and Butland ("A method for constructing local monotone piecewise cubic
interpolants", 1984), coordinate by coordinate: where positions rise the path rises, where they turn it turns there, and
along a straight line it stays on that line. Velocity is continuous, over the seam of a repeating path too.
"""

import numpy as np
from numpy.typing import NDArray

from controller.law import Desired
from messaging.control import Target

Array = NDArray[np.float64]


def along(target: Target, path_s: float | Array) -> Desired:
    """Where nodal points (..., m, 3) are at moments (...) of the path, and how fast they move, per second of the path.

    Before its first moment and after its last the path stands still; one that repeats goes on.
    """
    times, positions = target.time_s, target.position_mm
    last = len(times) - 1
    moment_s = np.asarray(path_s, dtype=np.float64)
    if not last:
        node_mm = np.broadcast_to(positions[0], (*moment_s.shape, *positions.shape[1:]))
        return Desired(node_mm=node_mm, velocity_mm_s=np.zeros(node_mm.shape))
    seam = int(np.searchsorted(times, target.repeat_from_s))
    rounds = np.zeros(moment_s.shape)
    if target.repeat:
        round_s = times[-1] - times[seam]
        rounds = np.maximum(np.floor((moment_s - times[seam]) / round_s), 0.0)
        moment_s = moment_s - rounds * round_s
    piece = np.minimum(np.maximum(np.searchsorted(times, moment_s, side="right") - 1, 0), last - 1)
    before, after = np.maximum(piece - 1, 0), np.minimum(piece + 1, last - 1)
    if target.repeat:
        before = np.where((rounds > 0) & (piece == seam), last - 1, before)
        after = np.where(piece == last - 1, seam, after)
    three = np.stack([before, piece, after])
    steps_s = (times[three + 1] - times[three])[..., None, None]
    slopes = (positions[three + 1] - positions[three]) / steps_s
    own, width_s = slopes[1], steps_s[1]
    low, high = _slope(slopes[:2], steps_s[:2]), _slope(slopes[1:], steps_s[1:])
    inside_s = np.minimum(np.maximum(moment_s, 0.0), times[-1])
    u = (inside_s - times[piece])[..., None, None] / width_s
    bow, lean = low + high - 2 * own, 3 * own - 2 * low - high
    node_mm = positions[piece] + width_s * u * (low + u * (lean + u * bow))
    moving = ((moment_s >= 0) & (moment_s < times[-1]))[..., None, None]
    return Desired(node_mm=node_mm, velocity_mm_s=moving * (low + u * (2 * lean + 3 * u * bow)))


def _slope(two: Array, steps_s: Array) -> Array:
    """Between two pieces of these slopes (2, ..., m, 3) and widths: their weighted harmonic mean, or 0 where they differ in sign."""
    share = (steps_s[0] + 2 * steps_s[1]) / (3 * (steps_s[0] + steps_s[1]))
    product = two[0] * two[1]
    mean = share * two[1] + (1 - share) * two[0]
    slope: Array = np.where(product > 0, product, 0.0) / np.where(product > 0, mean, 1.0)
    return slope
