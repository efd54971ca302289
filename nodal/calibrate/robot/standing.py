"""Where a robot that was led somewhere stands, from shapes in which it stood still."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from messaging.shape import ShapeEstimate
from nodal.calibrate.hand import Glimpse

Array = NDArray[np.float64]

_STILL_MM = 0.05


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Stand:
    """Where the robot stood: axes (A,), currents (A,), nodal points (k, 3) at `arc_mm` (k,), known to `sigma_mm` (k,)."""

    position_mm: Array
    current_ma: Array
    node_mm: Array
    sigma_mm: Array
    arc_mm: Array

    @classmethod
    def of(cls, shapes: Sequence[ShapeEstimate], glimpses: Sequence[Glimpse]) -> "Stand":
        """The mean of what was seen of a robot at rest."""
        nodes = np.array([shape.node_mm for shape in shapes])
        said = np.mean(
            [np.trace(shape.node_covariance_mm2, axis1=1, axis2=2) / 3 for shape in shapes], axis=0
        )
        return cls(
            position_mm=np.mean([glimpse.position_mm for glimpse in glimpses], axis=0),
            current_ma=np.mean([glimpse.current_ma for glimpse in glimpses], axis=0),
            node_mm=nodes.mean(axis=0),
            sigma_mm=np.sqrt(said / len(shapes)),
            arc_mm=shapes[-1].node_arc_mm,
        )


def still(shapes: Sequence[ShapeEstimate]) -> bool:
    """Whether the first half shows the same as the second, as far as can be seen."""
    nodes = np.array([shape.node_mm for shape in shapes])
    half = len(nodes) // 2
    apart_mm = np.linalg.norm(nodes[:half].mean(axis=0) - nodes[half:].mean(axis=0), axis=1)
    variance = np.trace(shapes[-1].node_covariance_mm2, axis1=1, axis2=2)
    return bool((apart_mm <= np.maximum(_STILL_MM, 3 * np.sqrt(variance / half))).all())
