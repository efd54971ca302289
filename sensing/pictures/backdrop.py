"""What a camera sees without the robot, and how far a picture differs from it (METHOD step 2, equation 1).

The backdrop is a picture taken without the robot; failing that one colour; failing that a smooth surface fitted to the
picture itself, which follows gradients and vignetting but neither folds nor the holder.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image, light_gains, luma, relit
from sensing.pictures.surface import Surface

Distances = NDArray[np.float32]
Window = tuple[slice, slice]
"""Rows and columns of a part of a picture."""

WHOLE: Window = (slice(None), slice(None))
LIGHT_STRIDE = 6
"""Every so many detection pixels, across and down, are compared to learn how the light has changed."""
SAME_LIGHT = 0.01
"""A change of the light by less is not worth following: it is below one level."""


@dataclass(frozen=True)
class Backdrop:
    """One camera's backdrop: `small` (h, w, 3) BGR in detection pixels, and `luma` (H, W), its brightness at full size.

    Colours between `low` and `high`, both like `small`, are the backdrop's: those that a pixel and its neighbours show.
    `source` is the BGR picture (H, W, 3) without the robot, or a surface fitted to one with it; `gains` (4,) is
    how much stronger the light on B, G, R and luma has become since, None for not at all.
    """

    grid: Grid
    small: Image
    low: Image
    high: Image
    luma: Image
    source: Image | Surface
    gains: FloatArray | None = None

    @classmethod
    def from_picture(cls, picture: Image) -> "Backdrop":
        """The backdrop in a picture taken without the robot; noise is smoothed away.

        A camera that was nudged, or a fold that moved, shows a neighbour's colour where there was another.
        """
        smooth = np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.0), dtype=np.uint8)
        grid = Grid.of((picture.shape[1], picture.shape[0]))
        small, near = grid.reduced(smooth), np.ones((3, 3), np.uint8)
        low, high = (np.asarray(change(small, near), dtype=np.uint8) for change in (cv2.erode, cv2.dilate))
        return cls(grid, small, low, high, luma(smooth), smooth)

    @classmethod
    def from_colour(cls, colour_bgr: tuple[float, float, float], size_px: tuple[int, int]) -> "Backdrop":
        """A backdrop of one colour (equation 1's R0, G0, B0, here in B, G, R order)."""
        grid = Grid.of(size_px)
        picture = np.full((size_px[1], size_px[0], 3), np.round(colour_bgr), dtype=np.uint8)
        small = grid.reduced(picture)
        return cls(grid, small, small, small, luma(picture), picture)

    @classmethod
    def fitted(cls, picture: Image, grid: Grid | None = None) -> "Backdrop":
        """A smooth surface through the picture's own background; `picture` is of full size, or in the pixels of `grid`."""
        grid = grid or Grid((picture.shape[1], picture.shape[0]), 1)
        return cls.from_surface(Surface.fitted(picture, grid).coefficients, grid.size_px)

    @classmethod
    def from_surface(cls, coefficients: FloatArray, size_px: tuple[int, int]) -> "Backdrop":
        """The backdrop that was fitted with these coefficients (10, 3), at this size (width, height)."""
        grid, surface = Grid.of(size_px), Surface(coefficients)
        small = surface.painted(size_px, grid.shape)
        return cls(grid, small, small, small, surface.luma(size_px), surface)

    @property
    def surface(self) -> FloatArray | None:
        """The coefficients (10, 3) of a fitted backdrop, None for any other."""
        return self.source.coefficients if isinstance(self.source, Surface) else None

    @property
    def picture(self) -> Image:
        """The backdrop as a BGR picture (H, W, 3) at full size, made when it is asked for."""
        if isinstance(self.source, Surface):
            return self.source.painted(self.grid.size_px, self.grid.size_px[::-1])
        return self.source if self.gains is None else relit(self.source, self.gains[:3])

    def in_light_of(self, small: Image) -> "Backdrop":
        """The same backdrop under the light of a picture in detection pixels (exposure, lamps, white balance)."""
        sparse = np.s_[::LIGHT_STRIDE, ::LIGHT_STRIDE]
        pairs = [
            np.concatenate([colours, luma(colours)[..., None]], axis=2).reshape(-1, 4)
            for colours in (np.ascontiguousarray(picture[sparse]) for picture in (small, self.small))
        ]
        gains = light_gains(*pairs)
        return self if np.abs(gains - 1.0).max() < SAME_LIGHT else self.relit(gains)

    def relit(self, gains: FloatArray) -> "Backdrop":
        """The same backdrop under light that is stronger by `gains` (4,)."""
        small, low, high = (relit(picture, gains[:3]) for picture in (self.small, self.low, self.high))
        return replace(self, small=small, low=low, high=high, luma=relit(self.luma, gains[3:]), gains=gains)

    def distance(self, small: Image, window: Window = WHOLE) -> Distances:
        """Equation 1: the Euclidean colour distance (h, w) of a part of a picture, in detection pixels, from the backdrop."""
        # at every place and in every colour one of the two differences saturates at zero
        outside = cv2.add(cv2.subtract(small, self.high[window]), cv2.subtract(self.low[window], small))
        squares = np.zeros(outside.shape[:2], dtype=np.float32)
        for colour in cv2.split(outside):
            cv2.accumulateSquare(colour, squares)
        return np.asarray(cv2.sqrt(squares), dtype=np.float32)


def noise_level(distance: Distances) -> float:
    """The typical colour distance of backdrop pixels: most of the picture is backdrop, so the median speaks for it."""
    return float(np.median(distance[::4, ::4]))
