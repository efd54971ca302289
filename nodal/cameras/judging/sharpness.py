"""How wide edges are in a picture. Pure.

An edge that a lens blurs by a Gaussian of width s (px, standard deviation) has, after smoothing by a further one of width a, a
gradient of height proportional to 1 / sqrt(s² + a²). Two smoothings give the ratio R of two heights, and

    s² = (b² - R² a²) / (R² - 1)

(S. Zhuo and T. Sim, "Defocus map estimation from a single image", Pattern Recognition 44 (2011), with a first
smoothing so that noise counts less.) Shadows and shading are soft by themselves, so only strong edges speak for the lens.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.light import Image

FINE_PX, COARSE_PX = 1.0, 2.0
DIFFERENCE_PX2 = 1 / 3
"""The variance of what the difference of a pixel's two neighbours averages over, which smooths too."""
STRONG_LEVELS = 25.0
"""An edge counts whose two sides differ by about as much."""
PIXEL_PX2 = 1 / 12
"""The variance of what a pixel averages over: no picture is sharper."""
FEWEST = 200
FACTORS = (1, 2, 4)
RISE = 2.563
"""The way from 10 to 90 % of a step that is blurred by a Gaussian, in its standard deviations."""


@dataclass(frozen=True, eq=False)
class Edges:
    """Places (n, 2) of edge pixels, x and y, and the blur (n,) of each, a standard deviation in px."""

    places: NDArray[np.intp]
    blur_px: FloatArray

    @property
    def width_px(self) -> float | None:
        """How wide edges typically are from 10 to 90 % of their step; None where there are none."""
        return RISE * float(np.median(self.blur_px)) if len(self.blur_px) else None


def edges_in(luma: Image) -> Edges:
    """The strong edges of a brightness picture (h, w); of a smaller one where blur leaves few that are strong at full size.

    There are none where they add up to less than FEWEST px.
    """
    height, width = luma.shape
    for factor in FACTORS:
        size = max(width // factor, 1), max(height // factor, 1)
        small = cv2.resize(luma, size, interpolation=cv2.INTER_AREA) if factor > 1 else luma
        edges = _edges(np.asarray(small, dtype=np.uint8))
        if len(edges.blur_px) >= FEWEST / factor:
            return Edges(edges.places * factor + factor // 2, edges.blur_px * factor)
    return Edges(np.empty((0, 2), dtype=np.intp), np.empty(0))


def _edges(luma: Image) -> Edges:
    fine, coarse = _gradient(luma, FINE_PX), _gradient(luma, COARSE_PX)
    height = np.hypot(*fine)
    # a step of d levels has a gradient of d / (sqrt(2 pi) sigma) at its middle
    strong = height > STRONG_LEVELS / (np.sqrt(2 * np.pi) * COARSE_PX)
    rows, columns = np.nonzero(strong & _is_crest(height, fine))
    ratio = (height[rows, columns] / np.maximum(np.hypot(*coarse)[rows, columns], 1e-6)) ** 2
    usable = ratio > 1.0
    fine_px2, coarse_px2 = (sigma_px**2 + DIFFERENCE_PX2 for sigma_px in (FINE_PX, COARSE_PX))
    squares = (coarse_px2 - ratio[usable] * fine_px2) / (ratio[usable] - 1.0)
    blur_px = np.sqrt(np.maximum(squares, PIXEL_PX2)).astype(np.float64)
    return Edges(np.column_stack([columns, rows])[usable], blur_px)


def _gradient(luma: Image, sigma_px: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Along x and y, of the smoothed picture."""
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), sigma_px)
    across, down = np.array([[-0.5, 0.0, 0.5]]), np.array([[-0.5], [0.0], [0.5]])
    return tuple(np.asarray(cv2.filter2D(smooth, cv2.CV_32F, kernel)) for kernel in (across, down))  # type: ignore[return-value]


def _is_crest(height: NDArray[np.float32], gradient: tuple[NDArray[np.float32], ...]) -> NDArray[np.bool_]:
    """Where the gradient is highest across the edge; both neighbours along x or y, whichever the edge crosses more."""
    inside = np.zeros(height.shape, dtype=bool)
    middle = height[1:-1, 1:-1]
    level = (middle >= height[1:-1, :-2]) & (middle > height[1:-1, 2:])
    upright = (middle >= height[:-2, 1:-1]) & (middle > height[2:, 1:-1])
    across = np.abs(gradient[0]) > np.abs(gradient[1])
    inside[1:-1, 1:-1] = np.where(across[1:-1, 1:-1], level, upright)
    return inside
