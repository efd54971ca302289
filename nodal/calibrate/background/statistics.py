"""What a scene that stands still looks like over several pictures: its mean, its noise, and how steady the light is. Pure."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image, luma

TILES = 12
"""Across a picture, to see where it is noisier."""
IMMERKAER = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32) / 6
"""Answers to noise alone (J. Immerkaer, Fast noise variance estimation, 1996)."""
STIRRED = 8.0
"""Something moved where brightness ranges over so many times its noise."""
SMALLEST_STIRRED = 60
"""Detection pixels; less is noise."""

Box = tuple[int, int, int, int]
"""Left, top, width, height in px."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Statistics:
    """Of one camera: `mean` (h, w, 3) BGR without noise, `noise` (3,) its standard deviation in one picture, B, G, R.

    `tile_noise` (rows, columns) is brightness' noise over the picture, `brightness` (n,) each picture's mean level, `stirred` where
    something has moved. With one picture noise is told from its grain, and nothing is known of the light and of what moved.
    """

    mean: Image
    count: int
    noise: FloatArray
    tile_noise: FloatArray
    brightness: FloatArray
    stirred: tuple[Box, ...]

    @property
    def flicker(self) -> float:
        """By what share the brightness of whole pictures varies (standard deviation over mean)."""
        return float(self.brightness.std() / max(self.brightness.mean(), 1.0))


class Pictures:
    """Takes pictures (h, w, 3) in BGR one by one and keeps sums alone."""

    def __init__(self) -> None:
        self._count = 0
        self._brightness: list[float] = []
        self._sum: NDArray[np.float32] | None = None
        self._squares: NDArray[np.float32] | None = None
        self._lowest: NDArray[np.float32] | None = None
        self._highest: NDArray[np.float32] | None = None
        self._grain: FloatArray = np.zeros(3)

    def add(self, picture: Image) -> None:
        """One more, of the size of those before."""
        colours = picture.astype(np.float32)
        small = Grid.of((picture.shape[1], picture.shape[0])).reduced(luma(picture))
        brightness = float(small.mean())
        smooth = np.asarray(cv2.GaussianBlur(small.astype(np.float32), (0, 0), 1.5)) / np.float32(
            max(brightness, 1.0)
        )
        if self._sum is None or self._squares is None or self._lowest is None or self._highest is None:
            self._sum, self._squares = np.zeros_like(colours), np.zeros_like(colours)
            self._lowest, self._highest = smooth, smooth
            self._grain = _grain(picture)
        self._sum += colours
        self._squares += colours * colours
        self._lowest, self._highest = np.minimum(self._lowest, smooth), np.maximum(self._highest, smooth)
        self._brightness.append(brightness)
        self._count += 1

    def statistics(self) -> Statistics:
        """Of all that were added, one at least."""
        if self._sum is None or self._squares is None or self._lowest is None or self._highest is None:
            raise ValueError("there is no picture to tell of")
        mean = self._sum / self._count
        if self._count == 1:
            noise, spread = self._grain, np.full(mean.shape[:2], self._grain.mean(), dtype=np.float32)
        else:
            variance = (
                np.maximum(self._squares / self._count - mean**2, 0.0) * self._count / (self._count - 1)
            )
            typical = np.array([float(np.median(channel)) for channel in cv2.split(variance)])
            noise = np.sqrt(typical / _median_of_chi_square(self._count - 1))
            spread = np.sqrt(variance.mean(axis=2))
        rows = max(round(TILES * mean.shape[0] / mean.shape[1]), 1)
        return Statistics(
            mean=np.rint(mean).astype(np.uint8),
            count=self._count,
            noise=noise,
            tile_noise=np.asarray(
                cv2.resize(spread, (TILES, rows), interpolation=cv2.INTER_AREA), dtype=np.float64
            ),
            brightness=np.array(self._brightness),
            stirred=_stirred(self._highest - self._lowest, mean.shape[1]),
        )


def _grain(picture: Image) -> FloatArray:
    answers = [cv2.filter2D(channel, cv2.CV_32F, IMMERKAER) for channel in cv2.split(picture)]
    return np.array([1.4826 * float(np.median(np.abs(answer))) for answer in answers])


def _median_of_chi_square(degrees: int) -> float:
    """Over its mean (E. B. Wilson and M. M. Hilferty, 1931)."""
    return float((1 - 2 / (9 * degrees)) ** 3)


def _stirred(ranges: NDArray[np.float32], width_px: int) -> tuple[Box, ...]:
    """Boxes around what has moved."""
    typical = float(np.median(ranges)) + 1e-4
    moved = cv2.morphologyEx(
        (ranges > STIRRED * typical).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)
    )
    _, _, boxes, _ = cv2.connectedComponentsWithStats(moved, connectivity=8)
    step = round(width_px / ranges.shape[1])
    return tuple(
        (int(x) * step, int(y) * step, int(width) * step, int(height) * step)
        for x, y, width, height, area in boxes[1:]
        if area >= SMALLEST_STIRRED
    )
