"""What is no whole picture of the right size is refused in words that name the camera, and never taken for one."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensing.errors import ImageSizeError, SensingError, UnreadableImageError
from sensing.pictures.picture import Picture

SIZE = 160, 112
LOOKS = {
    "colour": lambda picture: picture.colour,
    "luma": lambda picture: picture.luma,
    "half": lambda picture: picture.reduced(2),
    "eighth": lambda picture: picture.reduced(8),
    "part": lambda picture: picture.luma_around((0, 0, *SIZE))[0],
}
looks = pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)


def scenery():
    """Something that no two parts of are alike."""
    rng = np.random.default_rng(1)
    rough = rng.integers(0, 255, (SIZE[1], SIZE[0], 3)).astype(np.float32)
    return (cv2.GaussianBlur(rough, (0, 0), 2) * 3 - 250).clip(5, 250).astype(np.uint8)


def coded(picture, **options):
    """JPEG bytes, with what OpenCV can set: `rst_interval=4`."""
    flat = [(getattr(cv2, f"IMWRITE_JPEG_{name.upper()}"), value) for name, value in options.items()]
    return cv2.imencode(".jpg", picture, [number for pair in flat for number in pair])[1].tobytes()


KINDS = {
    "no markers": coded(scenery()),
    "markers": coded(scenery(), rst_interval=5),
    "4:4:4": coded(scenery(), sampling_factor=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
    "progressive": coded(scenery(), progressive=1),
    "grey": coded(scenery()[..., 0]),
}
PNG = cv2.imencode(".png", scenery())[1].tobytes()
BMP = cv2.imencode(".bmp", scenery())[1].tobytes()
END = b"\xff\xd9"
kinds = pytest.mark.parametrize("data", KINDS.values(), ids=KINDS)


def data_at(jpeg):
    """Where the data of the first scan begin."""
    scan = jpeg.index(b"\xff\xda")
    return scan + 2 + int.from_bytes(jpeg[scan + 2 : scan + 4], "big")


def cut(jpeg, kept, tail):
    """The JPEG up to a share of its first scan's data, and what follows there instead."""
    begin = data_at(jpeg)
    end = min(jpeg.find(marker, begin) for marker in (b"\xff\xc4", END) if marker in jpeg[begin:])
    return jpeg[: begin + round(kept * (end - begin))] + tail


def test_no_bytes_are_not_a_picture():
    with pytest.raises(UnreadableImageError, match=r"camera left: the picture is empty \(0 bytes\)"):
        Picture("left", b"", SIZE)


@kinds
@pytest.mark.parametrize("kept", [0.3, 0.6, 0.99])
@pytest.mark.parametrize("tail", [b"", bytes(3000)], ids=["nothing", "zeros"])
def test_a_jpeg_without_its_end_is_not_a_picture(data, kept, tail):
    stump = cut(data, kept, tail)
    with pytest.raises(
        UnreadableImageError, match=rf"camera left: the JPEG of {len(stump)} bytes is cut off"
    ):
        Picture("left", stump, SIZE)


@looks
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "progressive"])
@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("tail", [END, bytes(40) + END, bytes(9000) + END], ids=["end", "few", "many zeros"])
def test_a_jpeg_that_is_cut_off_is_refused_although_it_has_an_end(kind, look, kept, tail, capfd):
    """As a buffer is that was filled in part, with an end marker behind."""
    with pytest.raises(UnreadableImageError, match=r"camera left: the JPEG .*(damaged|missing|cut off)"):
        look(Picture("left", cut(KINDS[kind], kept, tail), SIZE))


@looks
@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9])
def test_a_progressive_jpeg_that_is_cut_off_in_its_first_scan_is_refused(look, kept, capfd):
    """Zeros in place of the rest would be the data of a rough picture: nothing would show that it is another one."""
    with pytest.raises(
        UnreadableImageError, match=r"camera left: .* its data are not those of all its pixels"
    ):
        look(Picture("left", cut(KINDS["progressive"], kept, END), SIZE))


@looks
def test_data_that_are_missing_within_are_told(look, capfd):
    """As when a packet was lost on the way: the rest moves up."""
    whole = KINDS["no markers"]
    middle = (data_at(whole) + len(whole)) // 2
    with pytest.raises(
        UnreadableImageError, match=r"camera left: .* its data are not those of all its pixels"
    ):
        look(Picture("left", whole[:middle] + whole[middle + 700 :], SIZE))


@looks
def test_a_stretch_between_markers_that_is_too_short_is_told(look, capfd):
    whole = KINDS["markers"]
    stretch = whole.index(b"\xff\xd3") - 200
    with pytest.raises(
        UnreadableImageError, match=r"camera left: .* its data are not those of all its pixels"
    ):
        look(Picture("left", whole[:stretch] + whole[stretch + 200 :], SIZE))


def test_a_restart_marker_that_is_lost_or_out_of_order_is_told():
    whole = KINDS["markers"]
    for damaged in (whole.replace(b"\xff\xd3", b"\xff\x00", 1), whole.replace(b"\xff\xd3", b"\xff\xd5", 1)):
        with pytest.raises(
            UnreadableImageError,
            match="camera left: the JPEG has 3 restart markers in their order where its header announces 13; a part",
        ):
            Picture("left", damaged, SIZE)


@looks
@pytest.mark.parametrize("options", [{}, {"rst_interval": 5}, {"optimize": 1}, {"progressive": 1}])
@pytest.mark.parametrize("level", [0, 128, 255])
def test_a_picture_may_be_grey_and_flat_to_its_end(look, options, level, capfd):
    """The very level that missing data are filled with, and data that are nothing but zeros."""
    flat = np.full((SIZE[1], SIZE[0], 3), level, np.uint8)
    assert (look(Picture("left", coded(flat, **options), SIZE)) == level).all()


@pytest.mark.parametrize(
    ("at", "byte", "reason"),
    [
        (1, 0xC9, r"kind SOF9 .*allowed are baseline and progressive"),
        (1, 0xC3, r"kind SOF3 .*allowed are baseline and progressive"),
        (4, 12, r"12 bits a sample; allowed are 8"),
        (9, 4, r"4 components; allowed are 1 \(grey\) and 3 \(colour\)"),
        (11, 0, r"no header that can be read"),
    ],
    ids=["arithmetic", "lossless", "12 bits", "CMYK", "no sampling"],
)
def test_a_jpeg_that_no_camera_makes_is_refused_by_its_kind(at, byte, reason):
    whole = bytearray(KINDS["no markers"])
    whole[whole.index(b"\xff\xc0") + at] = byte
    if at == 11:
        whole[whole.index(b"\xff\xc0") + 14] = whole[whole.index(b"\xff\xc0") + 17] = 0
    with pytest.raises(UnreadableImageError, match="camera left: the JPEG .*" + reason):
        Picture("left", bytes(whole), SIZE)


@looks
@pytest.mark.parametrize(
    "data",
    [*(PNG[:kept] for kept in (10, 100, -200, -20)), PNG[: len(PNG) // 2] + PNG[-12:], BMP[:20], BMP[:-1]],
)
def test_a_png_or_bmp_that_is_cut_off_is_not_a_picture(data, look, capfd):
    with pytest.raises(UnreadableImageError, match=r"camera left: .*(cut off|cannot be decoded)"):
        look(Picture("left", data, SIZE))


@pytest.mark.parametrize(
    "data",
    [
        b"hello",
        b"\x00" * 1000,
        b"\xff\xd8\xff\xd9",
        b"\xff\xd8" + b"\x00" * 500 + b"\xff\xd9",
        b"\x89PNG\r\n\x1a\n",
        b"RIFF\x10\x00\x00\x00WEBPVP8 ",
    ],
    ids=["words", "zeros", "empty jpeg", "hollow jpeg", "png's first bytes", "another format"],
)
def test_what_is_not_a_picture_is_said_so(data):
    with pytest.raises(UnreadableImageError, match="camera left: "):
        Picture("left", data, SIZE)


@pytest.mark.parametrize("data", [*KINDS.values(), PNG, BMP])
def test_another_size_is_an_error_with_both_sizes(data):
    with pytest.raises(
        ImageSizeError, match="camera left: the picture is 160x112 px, its calibration is for 1920x1080 px"
    ):
        Picture("left", data, (1920, 1080))


def test_a_huge_size_is_refused_before_anything_is_decoded(monkeypatch):
    def decoder(*_):
        raise AssertionError("decoded")

    monkeypatch.setattr(cv2, "imdecode", decoder)
    jpeg, png = bytearray(KINDS["no markers"]), bytearray(PNG)
    frame = jpeg.index(b"\xff\xc0")
    jpeg[frame + 5 : frame + 9] = b"\xff\xdc\xff\xdc"
    png[16:24] = b"\x7f\xff\xff\xff\x7f\xff\xff\xff"
    for data, side in ((jpeg, 65500), (png, 2**31 - 1)):
        with pytest.raises(ImageSizeError, match=f"camera left: the picture is {side}x{side} px"):
            Picture("left", bytes(data), SIZE)


changes = st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=12)), min_size=1, max_size=6)


@pytest.mark.parametrize("data", [*KINDS.values(), PNG, BMP], ids=[*KINDS, "png", "bmp"])
@pytest.mark.parametrize("inserted", [False, True])
@settings(max_examples=60)
@given(changes=changes, kept=st.floats(0.1, 1), look=st.sampled_from(list(LOOKS.values())))
def test_damage_leads_to_a_picture_or_to_an_error_that_names_the_camera(data, inserted, changes, kept, look):
    for share, replacement in changes:
        at = round(share * len(data))
        data = data[:at] + replacement + data[at + (0 if inserted else len(replacement)) :]
    data = data if kept > 0.5 else data[: round(kept * len(data))]
    try:
        shown = look(Picture("left", data, SIZE))
    except SensingError as error:
        said = str(error)
    else:
        assert shown.dtype == np.uint8
        assert shown.shape[1] in (SIZE[0], SIZE[0] // 2, SIZE[0] // 8)
        return
    assert said.startswith("camera left: ")
