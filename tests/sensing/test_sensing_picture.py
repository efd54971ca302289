"""Coded pictures: whatever a camera may rightly send is read, as finely as it is asked for."""

import cv2
import numpy as np
import pytest

from sensing.pictures.picture import Picture

SIZE = 64, 48


@pytest.fixture
def photograph():
    return np.random.default_rng(1).integers(60, 180, (48, 64, 3)).astype(np.uint8)


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


def test_sixteen_bits_are_scaled_and_not_cut(photograph):
    deep = (photograph.astype(np.float64) * 257 + 120).round().astype(np.uint16)
    data = cv2.imencode(".png", deep)[1].tobytes()
    assert np.array_equal(Picture("left", data, SIZE).colour, photograph)
    grey = cv2.imencode(".png", deep[..., 1])[1].tobytes()
    assert np.array_equal(Picture("left", grey, SIZE).luma, photograph[..., 1])
    full = cv2.imencode(".png", np.full((48, 64), 65535, np.uint16))[1].tobytes()
    assert Picture("left", full, SIZE).luma.min() == 255


@pytest.mark.parametrize(("kind", "bits"), [(".jpg", 8), (".png", 8), (".png", 16)])
def test_a_grey_picture_says_that_it_is(photograph, kind, bits):
    levels = photograph.astype(np.uint16) * 257 if bits == 16 else photograph
    grey, colour = (
        Picture("left", cv2.imencode(kind, one)[1].tobytes(), SIZE) for one in (levels[..., 0], levels)
    )
    assert (grey.grey, colour.grey) == (True, False)
    assert np.array_equal(grey.colour[..., 0], grey.colour[..., 2])
    assert np.abs(grey.luma.astype(int) - photograph[..., 0]).max() <= (0 if kind == ".png" else 60)


def test_transparency_is_not_looked_at(photograph):
    clear = np.dstack([photograph, np.zeros(photograph.shape[:2], np.uint8)])
    data = cv2.imencode(".png", clear)[1].tobytes()
    assert np.array_equal(Picture("left", data, SIZE).colour, photograph)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_an_orientation_in_exif_turns_nothing(photograph, encode, orientation):
    """A camera is calibrated as its sensor lies."""
    data = encode(photograph)
    entry = b"\x12\x01\x03\x00\x01\x00\x00\x00" + bytes((orientation, 0, 0, 0))
    exif = b"Exif\x00\x00II*\x00\x08\x00\x00\x00\x01\x00" + entry + bytes(4)
    turned = data[:2] + b"\xff\xe1" + (2 + len(exif)).to_bytes(2, "big") + exif + data[2:]
    assert np.array_equal(Picture("left", turned, SIZE).colour, Picture("left", data, SIZE).colour)
    assert np.array_equal(Picture("left", turned, SIZE).reduced(2), Picture("left", data, SIZE).reduced(2))


@pytest.mark.parametrize("padding", [b"\x00" * 30, b"\x00" * 5000, b"rubbish", b"\xff" * 9, b"\xff\xd9"])
@pytest.mark.parametrize("interval", [0, 4])
def test_a_jpeg_may_have_bytes_after_its_end(photograph, padding, interval):
    """Cameras pad their buffers."""
    data = cv2.imencode(".jpg", photograph, [cv2.IMWRITE_JPEG_RST_INTERVAL, interval])[1].tobytes()
    assert np.array_equal(Picture("left", data + padding, SIZE).luma, Picture("left", data, SIZE).luma)


LARGE = 483, 361
"""No multiple of eight."""


@pytest.mark.parametrize("factor", [1, 2, 4, 8, 16])
@pytest.mark.parametrize("kind", [".jpg", ".png"])
def test_a_reduced_picture_lies_where_it_says(encode, factor, kind):
    """The centre of a soft spot, in full-size px, from pictures of any size."""
    y, x = np.mgrid[: LARGE[1], : LARGE[0]]
    random = np.random.default_rng(factor)
    for _ in range(3):
        spot = random.uniform((120, 120), (360, 240))
        light = 180 * np.exp(-((x - spot[0]) ** 2 + (y - spot[1]) ** 2) / (2 * 18.0**2))
        data = encode(np.dstack([light, 0.6 * light, 0.9 * light]), kind)
        small = Picture("left", data, LARGE).reduced(factor)
        assert small.shape == (-(-LARGE[1] // factor), -(-LARGE[0] // factor), 3)
        for channel in range(3):
            seen = small[..., channel].astype(float)
            rows, columns = np.indices(seen.shape)
            centre = np.array([(seen * columns).sum(), (seen * rows).sum()]) / seen.sum()
            assert (centre + 0.5) * factor - 0.5 == pytest.approx(spot, abs=0.25)


@pytest.mark.parametrize("factor", [2, 4, 8])
def test_a_reduced_jpeg_is_near_to_the_mean_of_what_it_stands_for(factor, encode):
    random = np.random.default_rng(5)
    rough = random.integers(0, 255, (LARGE[1], LARGE[0], 3)).astype(np.float32)
    smooth = cv2.GaussianBlur(rough, (0, 0), 6) * 4 - 380
    data = encode(smooth)
    averaged = Picture("left", data, LARGE)
    assert averaged.colour is not None
    difference = Picture("left", data, LARGE).reduced(factor).astype(int) - averaged.reduced(factor)
    assert np.abs(difference[:-1, :-1].mean()) < 0.25
    assert np.sqrt((difference[:-1, :-1] ** 2).mean()) < 2.5
