"""What the search for slack remembers of one axis, and what one shape says of it. Pure."""

import dataclasses
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from controller.history import History
from controller.law import same_points

Array = NDArray[np.float64]


class Stroke(StrEnum):
    """What is done with one axis."""

    REST = "rest"
    """Stand still and see where the robot is."""
    FORTH = "forth"
    BACK = "back"
    MIDDLE = "middle"
    """Go to the middle of the lost motion."""
    TIGHTEN = "tighten"
    LOOK = "look"
    """Stand still until it is seen where the robot was pulled."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Rest:
    """Where nodal points (m, 3) at arc lengths (m,) were when the axis stood still; the mean of `shapes`."""

    arc_mm: Array
    node_mm: Array
    shapes: int
    seen_mm: float
    """How far a nodal point must move to be seen to move."""

    def shows(self, arc_mm: Array) -> bool:
        """True when nodal points at these arc lengths are the same."""
        return same_points(self.arc_mm, arc_mm)

    def apart_mm(self, node_mm: Array) -> float:
        """How far any nodal point is from where it rested."""
        return float(np.linalg.norm(node_mm - self.node_mm, axis=1).max())

    def then(self, node_mm: Array) -> "Rest":
        """The mean with one shape more."""
        mean = (self.shapes * self.node_mm + node_mm) / (self.shapes + 1)
        return dataclasses.replace(self, node_mm=mean, shapes=self.shapes + 1)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """How far the search has come. Positions and currents are those of `axis`."""

    axis: int
    stroke: Stroke
    since_s: float
    begin_mm: float
    """Command at which the axis rested."""
    lost_motion_mm: Array
    """(A,) of the axes that are done; NaN for the others and where the cameras could not tell."""
    positions: History
    current_ma: float
    """Averaged."""
    rest_ma: float = 0.0
    rest: Rest | None = None
    moved_mm: float = 0.0
    """How far any nodal point was seen to go, in this stroke."""
    turn_ma: float = 0.0
    """Current where the axis turned round."""
    turn_mm: float = 0.0
    """Furthest position of the servo."""
    followed_mm: float = 0.0
    """Furthest that the robot followed, as the model's displacement of the axis."""
    goal_mm: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """One shape against the rest: when it was captured, how far the robot followed (mm of the axis), how far any nodal point
    moved, and the cosine between that motion and the model's.
    """

    capture_s: float
    followed_mm: float
    moved_mm: float
    cosine: float

    @classmethod
    def of(cls, rest: Rest, node_mm: Array, motion: Array, capture_s: float) -> "Sight":
        """Nodal points (m, 3), which the model moves by `motion` (m, 3) per mm of the axis."""
        went = node_mm - rest.node_mm
        along = float((went * motion).sum())
        size, expected = float(np.linalg.norm(went)), float(np.linalg.norm(motion))
        return cls(
            capture_s=capture_s,
            followed_mm=along / max(expected**2, 1e-12),
            moved_mm=rest.apart_mm(node_mm),
            cosine=along / max(size * expected, 1e-12),
        )
