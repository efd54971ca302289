"""Where a robot is led to be identified: each axis alone, both ways, with reversals; then all together. Pure.

Poses are commands of all axes. Whoever leads the robot goes from one to the next axis by axis, tendons that let go first.
"""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from calibration.robot_model import Array

_STEPS = (0.5, 1.0, 0.0, -0.5, -1.0, 0.0)
"""An axis that pulls both ways."""
_TIGHTENING = (0.5, 1.0, 0.5, 0.0)
"""A single tendon, of what it may be pulled alone."""
_ALONE = 0.5
"""A single tendon that is pulled alone pulls against its neighbours: half as far as with them."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Reach:
    """How far commands may go."""

    tendon_mm: float
    """Either way, of every tendon or pair."""
    stage_mm: tuple[float, ...]
    """Places of the stage, the present one first; empty without a stage."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Poses (n, A), in turn."""

    alone_mm: Array
    together_mm: Array
    held_out_mm: Array
    """Others like `together_mm`, to be foreseen."""


def planned(
    command_of_coordinates: Array, paired: NDArray[np.bool_], reach: Reach, together: int, held_out: int
) -> Plan:
    """`command_of_coordinates` (D, 2 S) says how tendons share bends, `paired` (D,) which of them pull both ways."""
    poses = [*_alone(paired, reach), *_stage(len(paired), reach)]
    bends = _bends(command_of_coordinates, reach.tendon_mm, together + held_out)
    stage = reach.stage_mm[:1]
    bent = np.column_stack([bends, np.tile(stage, (len(bends), 1))])
    every = (together + held_out) // held_out
    foreseen = np.arange(len(bent)) % every == every - 1
    return Plan(
        alone_mm=np.array(poses), together_mm=_tour(bent[~foreseen]), held_out_mm=_tour(bent[foreseen])
    )


def _alone(paired: NDArray[np.bool_], reach: Reach) -> list[Array]:
    poses = []
    for axis, both in enumerate(paired):
        for share in _STEPS if both else _TIGHTENING:
            pose = np.append(np.zeros(len(paired)), reach.stage_mm[:1])
            pose[axis] = share * reach.tendon_mm * (1.0 if both else _ALONE)
            poses.append(pose)
    return poses


def _stage(tendons: int, reach: Reach) -> list[Array]:
    return (
        [np.append(np.zeros(tendons), place) for place in (*reach.stage_mm[1:], *reach.stage_mm[:1])]
        if reach.stage_mm
        else []
    )


def _bends(command_of_coordinates: Array, tendon_mm: float, number: int) -> Array:
    """(n, D) all sections bent at once, evenly over directions and sizes: a Kronecker sequence, one dimension of which is
    the direction and one the size for each section.
    """
    dimensions = command_of_coordinates.shape[1]
    root = _generalised_golden(dimensions)
    steps = root ** -np.arange(1, dimensions + 1)
    places = (0.5 + np.outer(np.arange(1, number + 1), steps)) % 1.0
    angle, size = 2 * np.pi * places[:, ::2], np.sqrt(places[:, 1::2])
    coordinates = np.stack([size * np.cos(angle), size * np.sin(angle)], axis=-1).reshape(number, dimensions)
    shares = coordinates @ command_of_coordinates.T
    poses: Array = tendon_mm * shares / np.maximum(np.abs(shares).max(axis=1, keepdims=True), 1.0)
    return poses


def _tour(poses_mm: Array) -> Array:
    """The same poses, from each to the nearest that is left."""
    left, place, order = list(range(len(poses_mm))), np.zeros(poses_mm.shape[1]), []
    while left:
        order.append(min(left, key=lambda pose: float(np.abs(poses_mm[pose] - place).sum())))
        left.remove(order[-1])
        place = poses_mm[order[-1]]
    return poses_mm[order]


def _generalised_golden(dimensions: int) -> float:
    """The root of x^(d + 1) = x + 1 (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018)."""
    root = 1.0
    for _ in range(50):
        root = float((1 + root) ** (1 / (dimensions + 1)))
    return root
