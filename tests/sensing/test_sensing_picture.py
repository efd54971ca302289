"""Coded pictures: what is not a whole picture of the right size is an error that names the camera."""

import numpy as np
import pytest

from sensing.errors import ImageSizeError, UnreadableImageError
from sensing.pictures.picture import Picture

SIZE = 64, 48


@pytest.fixture
def photograph():
    return np.random.default_rng(1).integers(60, 180, (48, 64, 3)).astype(np.uint8)


def both(data, size_px=SIZE):
    """Every way to look at a picture."""
    return [lambda: Picture("left", data, size_px).colour, lambda: Picture("left", data, size_px).luma]


@pytest.mark.parametrize("kind", [".jpg", ".png", ".bmp"])
def test_a_colour_picture_is_read(photograph, encode, kind):
    picture = Picture("left", encode(photograph, kind), SIZE)
    assert picture.colour.shape == (48, 64, 3)
    assert picture.luma.shape == (48, 64)
    if kind != ".jpg":
        assert np.array_equal(picture.colour, photograph)


def test_a_grey_jpeg_is_read_as_colours_that_are_alike(photograph, encode):
    data = encode(photograph[..., 0])
    picture = Picture("left", data, SIZE)
    assert picture.colour.shape == (48, 64, 3)
    assert np.array_equal(picture.colour[..., 0], picture.colour[..., 2])
    assert np.array_equal(Picture("left", data, SIZE).luma, picture.colour[..., 0])


def test_brightness_does_not_depend_on_what_was_looked_at_before(photograph, encode):
    smooth = np.full_like(photograph, (90, 150, 70))
    data = encode(smooth)
    first, second = Picture("left", data, SIZE), Picture("left", data, SIZE)
    assert first.colour is not None
    assert np.abs(first.luma.astype(int) - second.luma.astype(int)).max() <= 1


def test_no_bytes_are_not_a_picture():
    with pytest.raises(UnreadableImageError, match=r"camera left: the picture is empty \(0 bytes\)"):
        Picture("left", b"", SIZE)


@pytest.mark.parametrize("kept", [0.3, 0.6, 0.99])
def test_a_jpeg_that_is_cut_off_is_not_a_picture(photograph, encode, kept):
    data = encode(photograph)
    cut = data[: round(kept * len(data))]
    with pytest.raises(UnreadableImageError, match=rf"camera left: the JPEG of {len(cut)} bytes is cut off"):
        Picture("left", cut, SIZE)


@pytest.mark.parametrize("kept", [10, 100, -200, -20])
def test_a_png_that_is_cut_off_is_not_a_picture(photograph, encode, kept, capfd):
    data = encode(photograph, ".png")
    for look in both(data[:kept]):
        with pytest.raises(
            UnreadableImageError, match=r"camera left: .*(not a picture|cut off|cannot be decoded)"
        ):
            look()


@pytest.mark.parametrize(
    "data",
    [
        b"hello",
        b"\x00" * 1000,
        b"\xff\xd8\xff\xd9",
        b"\xff\xd8" + b"\x00" * 500 + b"\xff\xd9",
        b"\x89PNG\r\n\x1a\n",
    ],
    ids=["words", "zeros", "empty jpeg", "hollow jpeg", "png's first bytes"],
)
def test_what_is_not_a_picture_is_said_so(data):
    for look in both(data):
        with pytest.raises(UnreadableImageError, match="camera left: "):
            look()


def test_another_size_is_an_error_with_both_sizes(photograph, encode):
    for look in both(encode(photograph), (1920, 1080)):
        with pytest.raises(
            ImageSizeError, match="camera left: the picture is 64x48 px, its calibration is for 1920x1080 px"
        ):
            look()


def test_a_jpeg_may_have_bytes_after_its_end(photograph, encode):
    """Cameras pad their buffers."""
    assert Picture("left", encode(photograph) + b"\x00" * 30, SIZE).colour.shape == (48, 64, 3)
