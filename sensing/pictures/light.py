"""Levels of a picture and the light behind them: a lamp and a lens scale and mix light, not levels."""

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray

Image = NDArray[np.uint8]

_CODE = np.arange(256) / 255.0
LINEAR: FloatArray = 255.0 * np.where(_CODE <= 0.04045, _CODE / 12.92, ((_CODE + 0.055) / 1.055) ** 2.4)
"""Linear light of each 8-bit level, 0 to 255 (sRGB, IEC 61966-2-1)."""


def luma(picture: Image) -> Image:
    """Brightness (h, w) of a BGR picture; a grey one is returned as it is."""
    return (
        picture
        if picture.ndim == 2
        else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
    )


def relit(picture: Image, gains: FloatArray) -> Image:
    """The picture (h, w) or (h, w, k) under light that is stronger by `gains` (k,), one for each of its channels."""
    light = np.clip(LINEAR[:, None] * gains / 255.0, 0.0, 1.0)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    levels = np.rint(255.0 * code).astype(np.uint8).reshape(1, 256, -1)
    return np.asarray(cv2.LUT(picture, levels[..., 0] if picture.ndim == 2 else levels), dtype=np.uint8)


DARKEST, BRIGHTEST = 8, 248
"""Levels beyond which a sensor's black level or its clipping speaks."""
ALIKE = 0.15
LEAST_PIXELS = 100


def light_gains(seen: Image, known: Image) -> FloatArray:
    """By how much (k,) the light of pixels (n, k) is stronger than that of the same pixels (n, k) in a known picture.

    Most pixels show the same thing in both; what does not, or stands in a shadow, or is clipped, has no say. Where too few
    are left to tell it is 1.
    """
    return np.array([_light_gain(*channel) for channel in zip(seen.T, known.T, strict=True)])


def _light_gain(seen: Image, known: Image) -> float:
    low, high = np.minimum(seen, known), np.maximum(seen, known)
    usable = (low >= DARKEST) & (high <= BRIGHTEST)
    if np.count_nonzero(usable) < LEAST_PIXELS:
        return 1.0
    light, before = LINEAR[seen[usable]], LINEAR[known[usable]]
    ratio = light / before
    alike = np.abs(ratio / np.median(ratio) - 1.0) < ALIKE
    return float(light[alike].sum() / before[alike].sum())
