"""A JPEG with a patch is a JPEG like any other."""

import io

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.jpeg import Raster, splice

SIZES = [(1920, 1080), (1280, 720), (640, 480), (200, 100), (1000, 37)]


def picture(width: int, height: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    smooth = cv2.resize(rng.integers(0, 256, (9, 16, 3), dtype=np.uint8), (width, height))
    return cv2.add(smooth, rng.integers(0, 9, smooth.shape, dtype=np.uint8))


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize(
    "rough",
    [
        Window(700, 300, 1190, 1080),
        Window(-20, -5, 3, 2),
        Window(0, 0, 4000, 4000),
        Window(90, 30, 91, 31),
        Window(10, -400, 60, -300),
    ],
)
def test_a_patched_picture_decodes_to_what_the_whole_would(width: int, height: int, rough: Window) -> None:
    raster = Raster.of(width, height)
    window = raster.widen(rough)
    assert window.left <= max(rough.left, 0)
    assert window.right >= min(rough.right, width)
    behind, front = picture(width, height, 1), picture(width, height, 2)
    whole = behind.copy()
    whole[window.slices] = front[window.slices]
    patch = raster.encode(np.ascontiguousarray(front[window.slices]), 85)
    spliced = splice(raster.encode(behind, 85), patch, window, raster)
    assert spliced == raster.encode(whole, 85).code
    decoded = cv2.imdecode(np.frombuffer(spliced, np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(
        decoded, cv2.imdecode(cv2.imencode(".jpg", whole, PLAIN)[1], cv2.IMREAD_COLOR)
    )


PLAIN = [cv2.IMWRITE_JPEG_QUALITY, 85, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420]


def test_a_second_decoder_reads_it() -> None:
    image = pytest.importorskip("PIL.Image")
    raster = Raster.of(1920, 1080)
    window = raster.widen(Window(700, 300, 1190, 1080))
    front = picture(1920, 1080, 2)
    patch = raster.encode(np.ascontiguousarray(front[window.slices]), 85)
    spliced = splice(raster.encode(picture(1920, 1080, 1), 85), patch, window, raster)
    red = np.asarray(image.open(io.BytesIO(spliced)).convert("RGB"))
    blue = cv2.imdecode(np.frombuffer(spliced, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(red[:, :, ::-1].astype(int) - blue).max() <= 2
