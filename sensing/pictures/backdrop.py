"""What a camera sees without the robot, and how far a picture differs from it (METHOD step 2, equation 1).

The backdrop is a picture taken without the robot; failing that one colour; failing that a smooth surface fitted to the
picture itself, which follows gradients and vignetting but neither folds nor the holder.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray

Image = NDArray[np.uint8]

SCALE = 2
"""Detection works on pictures this many times smaller; measuring does not."""
FIT_STRIDE = 16


@dataclass(frozen=True)
class Backdrop:
    """One camera's backdrop. `picture` (h, w, 3) BGR is complete at full size; `small` is the reduced one.

    `surface` (10, 3) are the coefficients of a fitted one.
    """

    picture: Image
    small: Image
    luma: Image
    surface: FloatArray | None = None

    @classmethod
    def from_picture(cls, picture: Image) -> "Backdrop":
        """The backdrop in a picture taken without the robot; noise is smoothed away."""
        smooth = np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.0), dtype=np.uint8)
        return cls(smooth, reduced(smooth), luma(smooth))

    @classmethod
    def from_colour(cls, colour_bgr: tuple[float, float, float], size_px: tuple[int, int]) -> "Backdrop":
        """A backdrop of one colour (equation 1's R0, G0, B0, here in B, G, R order)."""
        picture = np.full((size_px[1], size_px[0], 3), colour_bgr, dtype=np.float64).round().astype(np.uint8)
        return cls(picture, reduced(picture), luma(picture))

    @classmethod
    def fitted(cls, picture: Image) -> "Backdrop":
        """A cubic surface per colour through the picture's own background, by reweighted least squares.

        Pixels that differ from the surface by more than a few times the typical difference (the robot, its holder)
        lose their say from one round to the next.
        """
        height, width = picture.shape[:2]
        colours = picture[::FIT_STRIDE, ::FIT_STRIDE].reshape(-1, 3).astype(np.float64)
        y, x = np.mgrid[0:height:FIT_STRIDE, 0:width:FIT_STRIDE]
        terms = _surface_terms(x.ravel() / width - 0.5, y.ravel() / height - 0.5)
        weight = np.ones(len(colours))
        coefficients: FloatArray = np.zeros((terms.shape[1], 3))
        for _ in range(12):
            weighted = terms.T * weight
            coefficients = np.asarray(np.linalg.solve(weighted @ terms, weighted @ colours))
            distance = np.linalg.norm(colours - terms @ coefficients, axis=1)
            scale = 2.0 * np.median(distance) + 1.0
            weight = 1.0 / (1.0 + (distance / scale) ** 2) ** 2
        return cls.from_surface(coefficients, (width, height))

    @classmethod
    def from_surface(cls, coefficients: FloatArray, size_px: tuple[int, int]) -> "Backdrop":
        """The backdrop that was fitted with these coefficients (10, 3), at this size (width, height)."""
        width, height = size_px
        columns, rows = width // FIT_STRIDE, height // FIT_STRIDE
        centres_y, centres_x = np.mgrid[0:rows, 0:columns]
        across = (centres_x.ravel() + 0.5) / columns - 0.5 / width - 0.5
        down = (centres_y.ravel() + 0.5) / rows - 0.5 / height - 0.5
        surface = (_surface_terms(across, down) @ coefficients).reshape(rows, columns, 3).astype(np.float32)
        smooth = cv2.resize(surface, (width, height), interpolation=cv2.INTER_LINEAR)
        whole = np.asarray(smooth.clip(0, 255).round(), dtype=np.uint8)
        return cls(whole, reduced(whole), luma(whole), coefficients)

    def distance(self, small: Image) -> FloatArray:
        """Equation 1: the Euclidean colour distance (h, w) between a reduced picture and the backdrop."""
        difference = cv2.absdiff(small, self.small).astype(np.float32)
        return np.asarray(np.sqrt(np.einsum("ijk,ijk->ij", difference, difference)))


def reduced(picture: Image) -> Image:
    """The picture at detection size: each pixel the mean of SCALE x SCALE."""
    return np.asarray(
        cv2.resize(picture, None, fx=1 / SCALE, fy=1 / SCALE, interpolation=cv2.INTER_AREA), dtype=np.uint8
    )


def luma(picture: Image) -> Image:
    """Brightness (h, w) of a BGR picture; a grey one is returned as it is."""
    return (
        picture
        if picture.ndim == 2
        else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
    )


def noise_level(distance: FloatArray) -> float:
    """The typical colour distance of backdrop pixels: most of the picture is backdrop, so the median speaks for it."""
    return float(np.median(distance[::4, ::4]))


def _surface_terms(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.column_stack([x**i * y**j for i in range(4) for j in range(4 - i)])
