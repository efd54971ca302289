"""What a camera sees behind the robot, and the noise of its sensor."""

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Pixels
from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.light import bgr
from drivers.simulated.cameras.settings import LightSettings


def paint_backdrop(width_px: int, height_px: int, light: LightSettings, shadow_px: Array) -> Pixels:
    """A plain backdrop that darkens towards its corners, with a soft shadow about (2,) `shadow_px`, without noise."""
    x = np.linspace(-1, 1, width_px, dtype=np.float32)[None, :]
    y = np.linspace(-1, 1, height_px, dtype=np.float32)[:, None]
    gradient = 1 - light.gradient * (0.8 * (x - 0.1) ** 2 + 0.5 * (y + 0.3) ** 2) / 1.3
    across = (np.float32(width_px / 2) * (x + 1) - np.float32(shadow_px[0])) / np.float32(0.09 * width_px)
    down = (np.float32(height_px / 2) * (y + 1) - np.float32(shadow_px[1])) / np.float32(0.35 * height_px)
    shadow = 1 - light.shadow * np.exp(-(across**2) - down**2)
    levels = (gradient * shadow)[:, :, None] * bgr(light.backdrop_colour).astype(np.float32)
    painted: Pixels = np.rint(np.clip(levels, 0, 255)).astype(np.uint8)
    return painted


class Noise:
    """Gaussian noise in every pixel and channel, drawn once; each use takes it from another corner."""

    def __init__(self, width_px: int, height_px: int, sigma_levels: float, rng: np.random.Generator) -> None:
        self._rng = rng
        self._size = np.array([height_px, width_px])
        shape = (height_px + height_px // 4, width_px + width_px // 4, 3)
        levels = np.rint(sigma_levels * rng.standard_normal(shape, dtype=np.float32)).astype(np.int16)
        self._brighter = np.clip(levels, 0, 255).astype(np.uint8)
        self._darker = np.clip(-levels, 0, 255).astype(np.uint8)

    def on(self, pixels: Pixels, window: Window) -> Pixels:
        """The pixels of the window with noise."""
        top, left = self._rng.integers(0, self._size // 4)
        rows = slice(window.top + top, window.bottom + top)
        columns = slice(window.left + left, window.right + left)
        # two saturating additions of bytes are many times faster than one with signs
        brighter = cv2.add(pixels, self._brighter[rows, columns])
        return np.asarray(cv2.subtract(brighter, self._darker[rows, columns], dst=brighter), dtype=np.uint8)
