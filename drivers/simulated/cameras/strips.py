"""Which piece of a tube a cell of pixels may show, roughly: strips along its projected middle, drawn with their numbers."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Index, Labels, Mask
from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.cells import label_map
from drivers.simulated.cameras.vectors import lengths, units


@dataclass(frozen=True)
class Strips:
    """Pieces of a tube between k points along its middle. Lengths are in cells."""

    middle: Array
    """(k, 2) columns and rows."""
    reach: Array
    """(k,) half the width that is drawn."""
    depth_mm: Array
    """(k,)."""
    end_on: Mask
    """(k,) where the tube points along the view, more or less."""

    def layers(self, window: Window) -> Iterator[Labels]:
        """Maps of 1 + the number of the piece: of what the tube may hide of itself, if anything, then of what is in front."""
        far_first = np.argsort(-self.depth_mm)
        front = self._draw(window, far_first)
        along = np.concatenate([[0.0], np.cumsum(lengths(np.diff(self.middle, axis=0)))])
        apart = np.pi * float(self.reach.max())
        if self._meets_itself(along, apart):
            back = self._draw(window, far_first[::-1])
            back[np.abs(along[back - 1] - along[front - 1]) < apart] = 0
            yield back
        yield front

    def _draw(self, window: Window, order: Index) -> Labels:
        """Pieces later in `order` hide earlier ones.

        Discs lie below all strips: they matter only where a piece is seen end on, and at the tip.
        """
        labels = label_map(window)
        along = units(np.gradient(self.middle, axis=0))
        across = np.column_stack([-along[:, 1], along[:, 0]]) * self.reach[:, None]
        left, right = self.middle + across, self.middle - across
        outlines = np.stack([left[:-1], right[:-1], right[1:], left[1:]], axis=1)
        rounded = np.rint(outlines).astype(np.int32)
        last = len(rounded)
        for piece in order[self.end_on[order] | (order == last)].tolist():
            column, row = np.rint(self.middle[piece]).astype(int).tolist()
            cv2.circle(labels, (column, row), int(self.reach[piece]) + 1, piece + 1, cv2.FILLED)
        for piece in order[order < last].tolist():
            cv2.fillConvexPoly(labels, rounded[piece], piece + 1)
        return labels

    def _meets_itself(self, along: Array, apart: float) -> bool:
        place = self.middle @ [1, 1j]
        near = np.abs(place[:, None] - place[None]) < 2 * float(self.reach.max())
        return bool((near & (np.abs(along[:, None] - along[None]) > apart)).any())
