"""How fast each axis should go so that nodal points move as asked: a quadratic programme within all limits. Pure.

Least squares over what is asked and what motion costs, under what must hold: rates, travels, a current beyond which no axis
pulls any harder, and the forbidden regions, which no part of the body nears faster than its distance allows (a control
barrier; Ames et al., "Control barrier functions: theory and applications", 2019). Outside of the regions standing still
satisfies all of them, so there is always an answer, also for what cannot be reached.

Solved by DAQP (Arnstrom, Bemporad, Axehill, "A dual active-set solver for embedded quadratic programming", 2022).
"""

import dataclasses
from typing import Self

import daqp
import numpy as np
from numpy.typing import NDArray

from controller.law import Desired
from controller.plant import Plant

Array = NDArray[np.float64]

_STOPPING_S = 0.1
"""Within which time an axis that nears the end of its travel comes to a stand, and the body before a region."""
_EASING = 0.7, 0.9
"""Shares of the allowed current between which an axis is slowed down from full speed to none."""
_LEAVING_MM_S = 5.0
"""How fast the body leaves a region that it got into, at most."""
_NEAR_MM = 20.0
"""Distance beyond which a region is no concern of the next moment."""
_WITHIN = 1 - 1e-9
"""So that rounding does not make a command exceed its rate."""
_SOLVED = 1


PLAN_S = 0.04
"""For how long rates may go on when no new shape comes, before they are found anew."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Wish:
    """Rates (n,) in mm/s asked of n coordinates that move by `rows` (n, A) for each mm of the axes."""

    rows: Array
    rate_mm_s: Array

    @classmethod
    def towards(
        cls,
        desired: Desired,
        node_mm: Array,
        jacobian: Array,
        weights: Array,
        *,
        feedback_per_s: float,
        most_mm_s: float,
    ) -> Self:
        """That points (m, 3), which move by (m, 3, A), go as desired and make good what they miss, each at `most_mm_s`."""
        rate = desired.velocity_mm_s + feedback_per_s * (desired.node_mm - node_mm)
        speed = np.linalg.norm(rate, axis=1, keepdims=True)
        rate *= np.minimum(1.0, most_mm_s / np.maximum(speed, 1e-9))
        root = np.sqrt(weights / weights.max())[:, None]
        rows = (jacobian * root[..., None]).reshape(-1, jacobian.shape[-1])
        return cls(rows=rows, rate_mm_s=(rate * root).ravel())

    @classmethod
    def none(cls, axes: int) -> Self:
        """Nothing is asked."""
        return cls(rows=np.zeros((1, axes)), rate_mm_s=np.zeros(1))


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """Points (b, 3) along the robot, and how they move (b, 3, A)."""

    point_mm: Array
    jacobian: Array


class Allocation:
    """The programme for one plant."""

    def __init__(self, plant: Plant, *, damping_mm: float, insertion_cost: float) -> None:
        """`damping_mm`: motion per mm of tendon below which nothing is pulled hard; the stage costs `insertion_cost` of it."""
        kinematics = plant.kinematics
        self._plant = plant
        tendon = np.arange(kinematics.axes) < kinematics.tendons
        self._damping = np.diag((damping_mm * np.where(tendon, 1.0, insertion_cost)) ** 2)

    def rates(
        self,
        wish: Wish,
        preferred_mm_s: Array,
        movable: NDArray[np.bool_],
        *,
        command_mm: Array,
        current_ma: Array | None,
        stretch: tuple[Array, Array],
        body: Body,
    ) -> Array:
        """(A,) mm/s felt of axes at `command_mm` that rather go at `preferred_mm_s`, where that costs the wish little.

        `stretch` says how much further axes must go than is felt of them, on the way back and on.
        """
        low, high = self._bounds(command_mm, current_ma)
        low, high = low / stretch[0], high / stretch[1]
        low, high = np.where(movable, low, 0.0), np.where(movable, high, 0.0)
        rows, least = self._barrier(body)
        hessian = wish.rows.T @ wish.rows + self._damping
        linear = -(wish.rows.T @ wish.rate_mm_s + self._damping @ preferred_mm_s)
        for bound in (least, np.minimum(least, 0.0)):  # no way out of a region must not mean no answer
            upper = np.concatenate([high, np.full(len(bound), np.inf)])
            rate, _, outcome, _ = daqp.solve(hessian, linear, rows, upper, np.concatenate([low, bound]))
            if outcome == _SOLVED:
                found: Array = np.minimum(np.maximum(rate, low), high)
                return found
        return np.zeros(len(low))

    def _bounds(self, command_mm: Array, current_ma: Array | None) -> tuple[Array, Array]:
        """Least and greatest rates (A,); zero lies between them."""
        limits = self._plant.limits
        rate = limits.rate_mm_s * _WITHIN
        low = np.maximum(-rate, np.minimum((limits.low_mm - command_mm) / _STOPPING_S, 0.0))
        high = np.minimum(rate, np.maximum((limits.high_mm - command_mm) / _STOPPING_S, 0.0))
        if current_ma is not None:
            begin, end = _EASING
            share = np.abs(current_ma) / limits.current_ma
            ease = np.minimum(np.maximum((end - share) / (end - begin), 0.0), 1.0)
            high = np.where(current_ma > 0, ease * high, high)
            low = np.where(current_ma < 0, ease * low, low)
        return low, high

    def _barrier(self, body: Body) -> tuple[Array, Array]:
        """How distances to regions move with the axes (n, A), and the least rates (n,) that they may have."""
        plant = self._plant
        if not len(plant.regions):
            return np.zeros((0, len(self._damping))), np.zeros(0)
        distance, outward = plant.regions.clearance(body.point_mm)
        spare = distance - plant.clearance_mm
        point, region = np.nonzero(spare < _NEAR_MM)
        rows = (outward[point, region][:, None, :] @ body.jacobian[point])[:, 0]
        return rows, np.minimum(-spare[point, region] / _STOPPING_S, _LEAVING_MM_S)


def tightening_mm_s(plant: Plant, current_ma: Array | None) -> Array:
    """(A,) rates that keep single tendons from going slack, and from being pulled needlessly hard; 0 for pairs.

    They bend nothing: a section's tendons are all pulled on or paid out together (Camarillo et al., "Mechanics modeling of
    tendon-driven continuum manipulators", 2008: only shifting all tensions keeps the moment).
    """
    tightening, limits = plant.kinematics.tightening, plant.limits
    if current_ma is None or not len(tightening) or plant.antagonistic.all():
        return np.zeros(plant.kinematics.axes)
    short = np.minimum(np.maximum(1.0 - current_ma / limits.least_tension_ma, 0.0), 1.0)
    spare = np.minimum(np.maximum(current_ma / limits.least_tension_ma - 3.0, 0.0), 1.0)
    rate: Array = tightening @ (np.where(plant.antagonistic, 0.0, short - spare / 3) * limits.tightening_mm_s)
    return rate
