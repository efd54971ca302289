"""Pixels two by two. What changes smoothly is found once for the middle of such a cell and spread to its four pixels.

Spread along its slope, a distance to an edge that is bent with a radius of r pixels is wrong by 1 / (8 r) pixels. The
last row or column of a picture of odd size belongs to no cell, and shows nothing of bodies found by cells.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Index, Labels
from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.projection import Projection

_SIDE_PX = 2
_REACH_PX = (
    1.5  # from a cell's middle to its corners, and as far again as outlines of whole cells are rounded
)
_OFFSETS_PX = np.array([[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]], np.float32)


@dataclass(frozen=True)
class Cells:
    """m cells of a window, of which each may show one part of a body."""

    part: Index
    """(m,) number of that part."""
    place: Index
    """(4, m) of their pixels in the window, counted row by row."""
    place_in_picture: Index
    """(4, m) of their pixels in the whole picture."""

    @classmethod
    def labelled(cls, labels: Labels, window: Window, width_px: int) -> Self:
        """Where a map has labels; `width_px` is the whole picture's."""
        flat = labels.reshape(-1)
        cell = np.flatnonzero(flat != 0)
        columns = labels.shape[1]
        row = cell // columns

        def places(width_px: int) -> Index:
            corners = np.array([[0], [1], [width_px], [width_px + 1]])
            found: Index = _SIDE_PX * (cell + row * (width_px - columns)) + corners
            return found

        return cls(
            part=flat.take(cell).astype(np.intp) - 1,
            place=places(window.shape[1]),
            place_in_picture=places(width_px) + (window.top * width_px + window.left),
        )

    def middle_rays(self, projection: Projection) -> tuple[Flat, Flat]:
        """X and y (m,) of the rays (x, y, 1) of their middles."""
        first_x, first_y = projection.rays(self.place_in_picture[0])
        last_x, last_y = projection.rays(self.place_in_picture[-1])
        return (first_x + last_x) * np.float32(0.5), (first_y + last_y) * np.float32(0.5)


def spread(middle: Flat, slope: Flat) -> Flat:
    """(4, m) values at the pixels of cells, from values (m,) at their middles and their slopes (2, m) to the right and down."""
    spread_out: Flat = middle + _OFFSETS_PX @ slope
    return spread_out


def label_map(window: Window) -> Labels:
    """An empty map of the window's cells, for drawing which part of a body a cell may show, counted from 1."""
    return np.zeros((window.shape[0] // _SIDE_PX, window.shape[1] // _SIDE_PX), np.int16)


def in_cells(pixels: Array, window: Window) -> Array:
    """Places (..., 2) in the picture as columns and rows of the window's cells."""
    return (pixels - window.corner - (_SIDE_PX - 1) / 2) / _SIDE_PX


def cells_reached(reach_px: Array | float) -> Array:
    """How many cells away from an outline pixels this far from it may lie in."""
    return (np.asarray(reach_px) + _REACH_PX) / _SIDE_PX
