"""What changes between pictures of one camera that were taken one after another. Pure."""

import itertools
from collections.abc import Sequence

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.pictures.light import LINEAR, Image

BLOCK_PX = 32
ROWS = 135
COLUMNS = 240
SMOOTHED_ROWS = 5


def noise_in(pictures: Sequence[Image]) -> float | None:
    """The standard deviation of a pixel in levels, from brightness pictures (h, w); None of fewer than two.

    It is that of the differences within blocks, the median over all blocks: neither what moves nor flicker counts.
    """
    pairs = [_difference(*pair) for pair in itertools.pairwise(pictures)]
    return float(np.sqrt(np.mean(np.square(pairs)))) if pairs else None


def _difference(one: Image, other: Image) -> float:
    difference = one.astype(np.float32) - other
    height, width = (size // BLOCK_PX * BLOCK_PX for size in one.shape)
    blocks = difference[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX)
    return float(np.median(blocks.std(axis=(1, 3))) / np.sqrt(2))


def flicker_in(pictures: Sequence[Image]) -> float | None:
    """By which share the light of a row changes from picture to picture, at worst; None of fewer than three.

    A camera that takes its rows one after another shows flickering lamps as bands that wander: so rows are compared, each
    by its median over the picture's width, in linear light.
    """
    if len(pictures) < 3:
        return None
    light = np.array([_small(picture) for picture in pictures])
    typical = np.maximum(np.median(light, axis=0), 1.0)
    rows = np.median(light / typical, axis=2)
    kernel = np.ones(SMOOTHED_ROWS) / SMOOTHED_ROWS
    smooth = np.array([np.convolve(row, kernel, mode="valid") for row in rows])
    return float((smooth.max(axis=0) - smooth.min(axis=0)).max())


def _small(picture: Image) -> FloatArray:
    small = cv2.resize(LINEAR.astype(np.float32)[picture], (COLUMNS, ROWS), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.float64)
