"""Which piece of a tube a pixel may show, roughly: strips along its projected middle, drawn with their numbers."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Index, Labels
from drivers.simulated.cameras.canvas import Window, draw_outline, label_map


@dataclass(frozen=True)
class Strips:
    """k points along the middle of the tube, in the window's pixels; a strip leads from each to the next."""

    middle_px: Array
    """(k, 2)."""
    reach_px: Array
    """(k,) half the width that is drawn."""
    depth_mm: Array
    """(k,)."""

    def layers(self, window: Window) -> Iterator[Labels]:
        """Maps of 1 + the number of the strip: of what the tube may hide of itself, if anything, then of what is in front."""
        far_first = np.argsort(-self.depth_mm)
        front = self._draw(window, far_first)
        along_px = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.middle_px, axis=0), axis=1))])
        apart_px = np.pi * float(self.reach_px.max())
        if self._meets_itself(along_px, apart_px):
            back = self._draw(window, far_first[::-1])
            back[np.abs(along_px[back - 1] - along_px[front - 1]) < apart_px] = 0
            yield back
        yield front

    def _draw(self, window: Window, order: Index) -> Labels:
        """Strips later in `order` hide earlier ones.

        Discs lie below all strips: they matter only where a piece is seen end on, and at the tip.
        """
        labels = label_map(window)
        along = np.gradient(self.middle_px, axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        across = np.column_stack([-along[:, 1], along[:, 0]]) * self.reach_px[:, None]
        left, right = self.middle_px + across, self.middle_px - across
        outlines = np.stack([left[:-1], right[:-1], right[1:], left[1:]], axis=1)
        rounded = np.rint(outlines).astype(np.int32)
        centres = np.rint(self.middle_px).astype(int).tolist()
        for piece in (*order[::2].tolist(), len(centres) - 1):
            cv2.circle(labels, centres[piece], int(self.reach_px[piece]) + 1, piece + 1, cv2.FILLED)
        for piece in order[order < len(rounded)].tolist():
            draw_outline(labels, rounded[piece], piece + 1)
        return labels

    def _meets_itself(self, along_px: Array, apart_px: float) -> bool:
        distance_px = np.linalg.norm(self.middle_px[:, None] - self.middle_px[None], axis=2)
        beyond = np.abs(along_px[:, None] - along_px[None]) > apart_px
        return bool((distance_px[beyond] < 2 * float(self.reach_px.max())).any())
