"""Which way each tendon bends the robot, against the drawing: what is wired or signed otherwise, by name. Pure."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from calibration.robot_model import Array

_ALIKE = 0.85
"""Cosine between what is seen and what is drawn, over all nodal points, above which they are the same motion. Other axes of a
robot with two sections reach 0.75 at most."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wired:
    """What one axis turned out to pull: `pulls` is the axis of the drawing that moves the robot most like it, `backwards` when
    it does so the other way, and `cosine` how much alike the two are, 0 to 1.
    """

    axis: int
    pulls: int
    backwards: bool
    cosine: float

    @property
    def reversed(self) -> bool:
        """It pulls what it should, the other way."""
        return self.pulls == self.axis and self.backwards and self.alike

    @property
    def alike(self) -> bool:
        """It moves the robot as some axis of the drawing does."""
        return self.cosine >= _ALIKE

    @property
    def misplaced(self) -> bool:
        """It pulls what another axis should."""
        return self.pulls != self.axis and self.alike


def wired(seen_mm: Array, drawn_mm: Array) -> tuple[Wired, ...]:
    """For each axis how nodal points moved, (D, k, 3), against how the drawing moves them, (D, k, 3); each with any length."""
    cosines = _cosines(seen_mm, drawn_mm)
    pulls = np.abs(cosines).argmax(axis=1)
    return tuple(
        Wired(
            axis=axis,
            pulls=int(like),
            backwards=bool(cosines[axis, like] < 0),
            cosine=float(abs(cosines[axis, like])),
        )
        for axis, like in enumerate(pulls)
    )


def turned_rad(seen_mm: Array, drawn_mm: Array) -> tuple[float, float]:
    """The one angle about +Z by which all that is seen is turned from the drawing, and the least cosine between an axis' motion
    and the drawing's that is left when it is undone.
    """
    size = np.linalg.norm(seen_mm, axis=(1, 2)) * np.linalg.norm(drawn_mm, axis=(1, 2))
    x, y = drawn_mm[..., 0], drawn_mm[..., 1]
    along = ((seen_mm[..., 0] * x + seen_mm[..., 1] * y).sum(axis=1) / size).sum()
    across = ((seen_mm[..., 1] * x - seen_mm[..., 0] * y).sum(axis=1) / size).sum()
    angle = float(np.arctan2(across, along))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return angle, float(np.diag(_cosines(seen_mm, drawn_mm @ turn.T)).min())


def _cosines(seen_mm: Array, drawn_mm: Array) -> NDArray[np.float64]:
    """(D, D) of each motion that is seen with each that is drawn."""
    seen, drawn = (motion.reshape(len(motion), -1) for motion in (seen_mm, drawn_mm))
    cosines: Array = seen @ drawn.T / np.outer(np.linalg.norm(seen, axis=1), np.linalg.norm(drawn, axis=1))
    return cosines
