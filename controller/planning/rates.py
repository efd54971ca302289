"""How fast the axes would have to move so that nodal points move as they are asked to. Pure."""

import numpy as np
from numpy.typing import NDArray

from controller.planning.space import Space

Array = NDArray[np.float64]

_DAMPING_MM_S = 0.1
"""Motion of nodal points at full rate below which an axis counts as not moving them."""
_SHARINGS = 12


def rate_shares(
    space: Space, configurations: Array, arc_mm: Array, root_weight: Array, velocity_mm_s: Array
) -> Array:
    """(k, A) which share of its allowed rate each axis needs, signed, when the busiest has as little to do as possible.

    Nodal points (n,) with these roots of their weights (n, 1) move by (k, n, 3) at the configurations (k, C). Where there is
    freedom, work is shared by Lawson's algorithm (least squares weighted by what was too much; Rice, Usow 1968).
    """
    rate_mm_s = space.plant.limits.rate_mm_s
    _, jacobian = space.kinematics.nodes_and_jacobian(space.commands(configurations), arc_mm)
    rows = (root_weight[..., None] * jacobian * rate_mm_s).reshape(len(configurations), -1, len(rate_mm_s))
    wished = (root_weight * velocity_mm_s).reshape(len(configurations), -1, 1)
    alike = np.ones((len(rows), len(rate_mm_s)))
    share = _least(rows, wished, alike)
    busy = np.flatnonzero(np.abs(share).max(axis=-1) > 1)
    weight = alike[busy]
    for _ in range(_SHARINGS if len(busy) else 0):
        weight *= np.abs(share[busy])
        weight /= weight.max(axis=-1, keepdims=True)
        better = _least(rows[busy], wished[busy], 1 / np.maximum(weight, 1e-4))
        improved = np.abs(better).max(axis=-1) < np.abs(share[busy]).max(axis=-1)
        share[busy[improved]] = better[improved]
    return share


def _least(rows: Array, wished: Array, ease: Array) -> Array:
    """(k, A) the least shares that do what is wished, an axis of twice the ease (k, A) counting half."""
    eased = rows * ease[:, None, :]
    across = eased @ rows.swapaxes(-1, -2) + _DAMPING_MM_S**2 * np.eye(rows.shape[1])
    share: Array = (eased.swapaxes(-1, -2) @ np.linalg.solve(across, wished))[..., 0]
    return share
