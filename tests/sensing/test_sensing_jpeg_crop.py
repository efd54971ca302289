"""A part of a JPEG decodes to exactly that part of the whole picture."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.errors import UnreadableImageError
from sensing.pictures.jpeg import Jpeg
from sensing.pictures.jpeg_crop import crop
from sensing.pictures.picture import Picture

SIZE = (200, 150)


def coded(interval, sampling=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420, *, colour=True, progressive=0):
    rng = np.random.default_rng(3)
    picture = cv2.GaussianBlur(rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8), (0, 0), 2)
    if not colour:
        picture = picture[..., 0]
    settings = [
        *(cv2.IMWRITE_JPEG_RST_INTERVAL, interval),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling),
        *(cv2.IMWRITE_JPEG_PROGRESSIVE, progressive),
    ]
    return cv2.imencode(".jpg", picture, settings)[1].tobytes()


def luma(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)


KINDS = {
    "4:2:0, whole rows": coded(13),
    "4:2:0, single units": coded(1),
    "4:2:2": coded(13, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422),
    "4:4:4": coded(5, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
    "4:4:0": coded(25, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_440),
    "4:1:1": coded(7, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_411),
    "grey": coded(5, colour=False),
}
WHOLE = {
    "no markers": coded(0),
    "markers across rows": coded(9),
    "progressive": coded(0, progressive=1),
    "progressive with markers": coded(13, progressive=1),
}

boxes = st.builds(
    lambda left, top, width, height: (left, top, left + width, top + height),
    st.integers(-20, 190),
    st.integers(-20, 140),
    st.integers(1, 250),
    st.integers(1, 200),
).filter(lambda box: box[2] > 0 and box[3] > 0)


@pytest.mark.parametrize("kind", KINDS)
@given(boxes)
def test_a_part_is_the_same_as_in_the_whole(kind, box):
    part, shown = crop(Jpeg.read("left", KINDS[kind]), box)
    assert len(part.data) <= len(KINDS[kind])
    assert np.array_equal(luma(part.data), luma(KINDS[kind])[shown[1] : shown[3], shown[0] : shown[2]])


@pytest.mark.parametrize("kind", KINDS | WHOLE)
@given(boxes)
def test_brightness_around_a_box_is_that_of_the_whole_picture(kind, box):
    data = (KINDS | WHOLE)[kind]
    seen, (x0, y0, x1, y1) = Picture("left", data, SIZE).luma_around(box)
    assert np.array_equal(seen, Picture("left", data, SIZE).luma[y0:y1, x0:x1])
    assert seen.shape == (y1 - y0, x1 - x0)
    assert x0 <= max(box[0], 0)
    assert y0 <= max(box[1], 0)
    assert x1 >= min(box[2], SIZE[0])
    assert y1 >= min(box[3], SIZE[1])


@pytest.mark.parametrize("kind", WHOLE)
def test_what_cannot_be_taken_apart_is_left_whole(kind):
    assert crop(Jpeg.read("left", WHOLE[kind]), (20, 20, 60, 60)) is None


def test_a_part_outside_of_the_picture_is_none():
    assert crop(Jpeg.read("left", KINDS["4:2:0, whole rows"]), (300, 0, 340, 20)) is None


def test_an_end_in_what_follows_the_picture_is_not_its_end():
    """Cameras pad their buffers with what was in them before."""
    padded = KINDS["4:2:0, whole rows"] + b"\xff\xd9\xff\xd0 old \xff\xd9"
    part, (x0, y0, x1, y1) = crop(Jpeg.read("left", padded), (100, 120, 120, 150))
    assert np.array_equal(luma(part.data), luma(KINDS["4:2:0, whole rows"])[y0:y1, x0:x1])


def test_a_header_that_names_no_components_or_ends_within_is_none():
    whole = KINDS["4:2:0, whole rows"]
    frame = whole.index(b"\xff\xc0")
    with pytest.raises(UnreadableImageError, match="camera left: the JPEG has 0 components"):
        Jpeg.read("left", whole[: frame + 9] + b"\0" + whole[frame + 10 :])
    for end in range(2, whole.index(b"\xff\xda") + 14):
        with pytest.raises(UnreadableImageError, match="camera left: "):
            Jpeg.read("left", whole[:end])


@given(st.binary(max_size=400), st.integers(2, 600))
def test_damage_to_the_header_is_said_and_nothing_else_happens(rubbish, at):
    whole = KINDS["4:2:0, whole rows"]
    try:
        crop(Jpeg.read("left", whole[:at] + rubbish + whole[at + len(rubbish) :]), (20, 20, 60, 60))
    except UnreadableImageError as error:
        said = str(error)
    else:
        return
    assert said.startswith("camera left: ")
