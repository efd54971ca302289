"""The pixels of detection: finding the robot takes fewer and larger ones than measuring it does."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.pictures.light import Image

WIDTH_PX = 960
"""About how wide a picture is for detection."""


@dataclass(frozen=True)
class Grid:
    """Detection pixels that stand for `step` x `step` of a full-size picture's; `size_px` is (width, height) in full-size px."""

    size_px: tuple[int, int]
    step: int

    @classmethod
    def of(cls, size_px: tuple[int, int]) -> "Grid":
        """The detection pixels of pictures of this size; the step is a power of two, as decoders can reduce by."""
        return cls(size_px, 2 ** max(round(math.log2(size_px[0] / WIDTH_PX)), 0))

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in detection pixels."""
        return -(-self.size_px[1] // self.step), -(-self.size_px[0] // self.step)

    def reduced(self, picture: Image) -> Image:
        """The full-size picture (h, w) or (h, w, k) in detection pixels: each the mean of those that it stands for."""
        if self.step == 1:
            return picture
        height, width = self.shape
        below, right = height * self.step - picture.shape[0], width * self.step - picture.shape[1]
        if below or right:
            picture = np.asarray(
                cv2.copyMakeBorder(picture, 0, below, 0, right, cv2.BORDER_REPLICATE), np.uint8
            )
        return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def coarse(self, pixels: FloatArray) -> FloatArray:
        """Full-size pixel coordinates as detection ones; both count from pixel centres."""
        return (pixels + 0.5) / self.step - 0.5

    def fine(self, pixels: FloatArray) -> FloatArray:
        """Detection pixel coordinates as full-size ones."""
        return (pixels + 0.5) * self.step - 0.5
