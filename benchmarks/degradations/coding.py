"""The sensor's noise, and how a picture is coded."""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike

from benchmarks.degradations.scenery import Image

Coder = Callable[[Image], bytes]

WEBCAM_QUALITY = 80


def jpeg(
    quality: int = WEBCAM_QUALITY,
    sampling: int = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
    *,
    progressive: bool = False,
) -> Coder:
    """JPEG of this quality, with colours at this resolution."""
    parameters = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        sampling,
        cv2.IMWRITE_JPEG_PROGRESSIVE,
        int(progressive),
    ]
    return lambda picture: cv2.imencode(".jpg", picture, parameters)[1].tobytes()


def grey_jpeg(picture: Image) -> bytes:
    """A JPEG with brightness alone."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    return cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, WEBCAM_QUALITY])[1].tobytes()


def png_16_bit(picture: Image) -> bytes:
    """A PNG with 16 bits a channel."""
    return cv2.imencode(".png", picture.astype(np.uint16) * 257, [cv2.IMWRITE_PNG_COMPRESSION, 1])[
        1
    ].tobytes()


def cut(coded: bytes) -> bytes:
    """The first half of a coded picture."""
    return coded[: len(coded) // 2]


def damaged(coded: bytes) -> bytes:
    """A coded picture of which some bytes in the middle were lost on their way."""
    middle = len(coded) // 2
    return coded[:middle] + coded[middle + 40 :]


def halved(coded: bytes) -> bytes:
    """A picture of the same scene of half the size."""
    return jpeg()(_bytes(cv2.resize(_picture(coded), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)))


def blackened(coded: bytes) -> bytes:
    """What the camera sees with its lens covered."""
    return jpeg()(_bytes(0 * _picture(coded)))


def noisy(picture: Image, sigma_levels: float, random: np.random.Generator) -> Image:
    """The picture with Gaussian noise in every pixel and channel."""
    height, width = picture.shape[:2]
    brighter, darker = _noise(height, width, sigma_levels)
    top, left = random.integers(0, height // 4), random.integers(0, width // 4)
    part = slice(top, top + height), slice(left, left + width)
    # two saturating additions of bytes are many times faster than one with signs
    return _bytes(cv2.subtract(cv2.add(picture, brighter[part]), darker[part]))


def _picture(coded: bytes) -> Image:
    return np.asarray(cv2.imdecode(np.frombuffer(coded, np.uint8), cv2.IMREAD_COLOR), np.uint8)


def _bytes(picture: ArrayLike) -> Image:
    return np.asarray(picture, dtype=np.uint8)


@lru_cache(maxsize=4)
def _noise(height: int, width: int, sigma_levels: float) -> tuple[Image, Image]:
    """Drawn once, larger than the picture: each picture takes it from another corner."""
    shape = (height + height // 4, width + width // 4, 3)
    drawn = np.random.default_rng(5).standard_normal(shape, dtype=np.float32)
    levels = np.rint(sigma_levels * drawn)
    return np.clip(levels, 0, 255).astype(np.uint8), np.clip(-levels, 0, 255).astype(np.uint8)
