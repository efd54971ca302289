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
    piece = np.clip(np.searchsorted(times, moment_s, side="right") - 1, 0, last - 1)
    before = np.where((rounds > 0) & (piece == seam), last - 1, piece - 1)
    after = np.where((piece == last - 1) & target.repeat, seam, piece + 1)
    before, after = np.maximum(before, 0), np.minimum(after, last - 1)
    steps, ways = np.diff(times), np.diff(positions, axis=0)
    width = steps[piece][..., None, None]
    own = ways[piece] / width
    low = _slope(ways[before] / steps[before][..., None, None], own, steps[before], steps[piece])
    high = _slope(own, ways[after] / steps[after][..., None, None], steps[piece], steps[after])
    u = (np.clip(moment_s, 0.0, times[-1])[..., None, None] - times[piece][..., None, None]) / width
    bow, lean = low + high - 2 * own, 3 * own - 2 * low - high
    node_mm = positions[piece] + width * u * (low + u * (lean + u * bow))
    moving = ((moment_s >= 0) & (moment_s < times[-1]))[..., None, None]
    return Desired(node_mm=node_mm, velocity_mm_s=moving * (low + u * (2 * lean + 3 * u * bow)))


def _slope(left: Array, right: Array, left_s: Array, right_s: Array) -> Array:
    """Between two pieces of slopes `left` and `right` (..., m, 3) and these widths: their weighted harmonic mean, or 0."""
    share = ((left_s + 2 * right_s) / (3 * (left_s + right_s)))[..., None, None]
    product = left * right
    mean = share * right + (1 - share) * left
    return np.where(product > 0, product / np.where(product > 0, mean, 1.0), 0.0)
