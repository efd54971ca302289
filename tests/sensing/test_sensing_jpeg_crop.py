"""A part of a JPEG decodes to exactly that part of the whole picture."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.pictures.jpeg_crop import crop

SIZE = (200, 150)


def coded(interval, sampling=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420, *, colour=True):
    rng = np.random.default_rng(3)
    picture = cv2.GaussianBlur(rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8), (0, 0), 2)
    if not colour:
        picture = picture[..., 0]
    settings = [cv2.IMWRITE_JPEG_RST_INTERVAL, interval, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling]
    return cv2.imencode(".jpg", picture, settings)[1].tobytes()


def luma(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)


KINDS = {
    "4:2:0, whole rows": coded(13),
    "4:2:0, single units": coded(1),
    "4:2:2": coded(13, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422),
    "4:4:4": coded(5, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
    "grey": coded(5, colour=False),
}


@pytest.mark.parametrize("kind", KINDS)
@given(
    st.tuples(st.integers(-20, 190), st.integers(-20, 140), st.integers(1, 250), st.integers(1, 200)).filter(
        lambda box: box[0] + box[2] > 0 and box[1] + box[3] > 0
    )
)
def test_a_part_is_the_same_as_in_the_whole(kind, box):
    left, top, width, height = box
    data, shown = crop(KINDS[kind], SIZE, (left, top, left + width, top + height))
    x0, y0, x1, y1 = shown
    assert np.array_equal(luma(data), luma(KINDS[kind])[y0:y1, x0:x1])
    assert x0 <= max(left, 0)
    assert y0 <= max(top, 0)
    assert x1 >= min(left + width, SIZE[0])
    assert y1 >= min(top + height, SIZE[1])


@pytest.mark.parametrize(
    "data",
    [
        coded(0),
        coded(7),
        coded(13)[: len(coded(13)) // 2] + b"\xff\xd9",
        b"",
        b"\xff\xd8",
        cv2.imencode(".jpg", np.zeros((9, 9, 3), np.uint8), [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes(),
    ],
    ids=["no markers", "markers across rows", "cut", "empty", "only a start", "progressive"],
)
def test_what_cannot_be_taken_apart_is_left_whole(data):
    assert crop(data, SIZE, (20, 20, 60, 60)) is None


def test_a_header_that_names_no_components_or_ends_within_is_left_whole():
    whole = KINDS["4:2:0, whole rows"]
    frame = whole.index(b"\xff\xc0")
    assert crop(whole[: frame + 9] + b"\0" + whole[frame + 10 :], SIZE, (20, 20, 60, 60)) is None
    for end in range(frame + 25):
        assert crop(whole[:end], SIZE, (20, 20, 60, 60)) is None


def test_a_picture_of_another_size_is_left_whole():
    assert crop(KINDS["grey"], (SIZE[1], SIZE[0]), (20, 20, 60, 60)) is None


def test_a_part_outside_of_the_picture_is_none():
    assert crop(KINDS["4:2:0, whole rows"], SIZE, (300, 0, 340, 20)) is None


@given(st.binary(max_size=400), st.integers(0, 600))
def test_damage_never_raises(rubbish, at):
    whole = KINDS["4:2:0, whole rows"]
    crop(whole[:at] + rubbish + whole[at + len(rubbish) :], SIZE, (20, 20, 60, 60))
