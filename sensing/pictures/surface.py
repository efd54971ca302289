"""A smooth surface for each colour, through a picture's own background."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image

COLUMNS = 96
"""Places across a picture at which it is read, and the surface is worked out."""
ROUNDS = 12


@dataclass(frozen=True)
class Surface:
    """Cubic surfaces: `coefficients` (10, 3) for B, G and R over a picture of any size."""

    coefficients: FloatArray

    @classmethod
    def fitted(cls, picture: Image, grid: Grid) -> "Surface":
        """By reweighted least squares, from a picture (h, w, 3) in the pixels of a grid.

        Pixels that differ from the surface by more than a few times the typical difference (the robot, its holder)
        lose their say from one round to the next.
        """
        width, height = grid.size_px
        stride = max(picture.shape[1] // COLUMNS, 1)
        colours = picture[::stride, ::stride].reshape(-1, 3).astype(np.float64)
        y, x = (
            grid.fine(place.ravel())
            for place in np.mgrid[: picture.shape[0] : stride, : picture.shape[1] : stride]
        )
        terms = _terms(x / width - 0.5, y / height - 0.5)
        weight = np.ones(len(colours))
        coefficients: FloatArray = np.zeros((terms.shape[1], 3))
        for _ in range(ROUNDS):
            weighted = terms.T * weight
            coefficients = np.asarray(np.linalg.solve(weighted @ terms, weighted @ colours))
            distance = np.linalg.norm(colours - terms @ coefficients, axis=1)
            scale = 2.0 * np.median(distance) + 1.0
            weight = 1.0 / (1.0 + (distance / scale) ** 2) ** 2
        return cls(coefficients)

    def painted(self, size_px: tuple[int, int], shape: tuple[int, int]) -> Image:
        """The surface over a picture of this size (width, height), as BGR pixels of another shape (h, w, 3)."""
        return _enlarged(self._colours(size_px), shape)

    def luma(self, size_px: tuple[int, int]) -> Image:
        """Its brightness (height, width) over a picture of this size (width, height)."""
        brightness = np.asarray(cv2.cvtColor(self._colours(size_px), cv2.COLOR_BGR2GRAY), dtype=np.float32)
        return _enlarged(brightness, size_px[::-1])

    def _colours(self, size_px: tuple[int, int]) -> NDArray[np.float32]:
        """At a few places (h, w, 3), evenly over the picture."""
        width, height = size_px
        columns, rows = COLUMNS, max(COLUMNS * height // width, 2)
        y, x = np.mgrid[0:rows, 0:columns]
        across = (x.ravel() + 0.5) / columns - 0.5 / width - 0.5
        down = (y.ravel() + 0.5) / rows - 0.5 / height - 0.5
        colours = (_terms(across, down) @ self.coefficients).reshape(rows, columns, 3)
        return np.asarray(np.maximum(colours, 0.0), dtype=np.float32)


def _enlarged(colours: NDArray[np.float32], shape: tuple[int, int]) -> Image:
    smooth = cv2.resize(colours, shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.convertScaleAbs(smooth), dtype=np.uint8)


def _terms(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.column_stack([x**i * y**j for i in range(4) for j in range(4 - i)])
