"""Nodal points held at places, and how much each of them counts."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from messaging.control import Target
from nodal.errors import CommandError


def points(positions_mm: Mapping[str, Sequence[float]], weights: Mapping[str, float]) -> Target:
    """Named nodal points held at fixed places; a weight not given is 1. Raises InvalidMessageError, CommandError."""
    names = tuple(positions_mm)
    return Target(
        name="point",
        node_names=names,
        weights=weights_of(names, weights),
        time_s=np.zeros(1),
        position_mm=np.array([[positions_mm[name] for name in names]], dtype=np.float64),
        repeat=False,
    )


def weights_of(names: Sequence[str], weights: Mapping[str, float]) -> NDArray[np.float64]:
    """(m,) the weights of these points, 1 unless given; raises CommandError for a name that is none of them."""
    if unknown := sorted(set(weights) - set(names)):
        raise CommandError(
            f"weight given for {', '.join(unknown)}; the target's points are {', '.join(names)}"
        )
    return np.array([weights.get(name, 1.0) for name in names], dtype=np.float64)
