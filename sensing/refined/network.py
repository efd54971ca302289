"""The lines of a thinned mask as a network: arcs without side branches, and the junctions at which they meet.

Around every branching pixel there is a disk about as large as the tube is thick: in there a line's course says nothing
(the rims of spacer disks, two crossing stretches), and branches that do not leave it are not branches. Disks that touch are one
junction.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray

STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
"""Neighbours, the nearest first, so that a walk does not cut corners."""


@dataclass(frozen=True, eq=False)
class Arc:
    """Pixels (n, 2) as (x, y), one after the other, and the junction at either end, None where it is free."""

    pixels: FloatArray
    start: int | None
    end: int | None

    def reversed(self) -> "Arc":
        """The same arc from its other end."""
        return Arc(self.pixels[::-1], self.end, self.start)

    @property
    def leads_nowhere(self) -> bool:
        """Whether it begins at a junction, and ends freely or at the same one."""
        return self.start != self.end if None in (self.start, self.end) else self.start == self.end

    @cached_property
    def length_px(self) -> float:
        """Its length."""
        return float(np.linalg.norm(np.diff(self.pixels, axis=0), axis=1).sum())


def network(lines: NDArray[np.bool_], radius_px: float) -> tuple[Arc, ...]:
    """The arcs of thin lines (h, w), with junctions of this radius."""
    ones = lines.astype(np.uint8)
    neighbours = cv2.filter2D(ones, cv2.CV_8U, np.ones((3, 3), np.float32), borderType=cv2.BORDER_CONSTANT)
    disks = np.zeros_like(ones)
    for y, x in zip(*np.nonzero(lines & (neighbours > 3)), strict=True):
        cv2.circle(disks, (int(x), int(y)), round(radius_px), 1, cv2.FILLED)
    junctions = np.asarray(cv2.connectedComponents(disks, connectivity=8)[1], dtype=np.int32)
    loose = {(int(x), int(y)) for y, x in zip(*np.nonzero(lines & (disks == 0)), strict=True)}
    arcs = []
    while loose:
        first = min(loose)
        loose.discard(first)
        pixels = [*_followed(first, loose)[::-1], first, *_followed(first, loose)]
        arcs.append(
            Arc(
                np.array(pixels, dtype=np.float64),
                _junction_at(pixels[0], junctions),
                _junction_at(pixels[-1], junctions),
            )
        )
    return tuple(arcs)


def _followed(place: tuple[int, int], loose: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """The pixels that follow one another from a place on; they are taken out of `loose`."""
    passed: list[tuple[int, int]] = []
    while True:
        x, y = place
        ahead = [(x + dx, y + dy) for dx, dy in STEPS if (x + dx, y + dy) in loose]
        if not ahead:
            return passed
        place = ahead[0]
        loose.discard(place)
        passed.append(place)


def _junction_at(pixel: tuple[int, int], junctions: NDArray[np.int32]) -> int | None:
    x, y = pixel
    near = junctions[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
    return int(near.max()) or None
