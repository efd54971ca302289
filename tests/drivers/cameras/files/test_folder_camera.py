"""Folders of pictures: which belong together, and that their bytes stay as they are."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cameras import CameraError, FolderCameraSettings
from drivers.cameras.files.numbering import numbers_in, together
from drivers.cameras.files.opening import file_cameras

NAMES = ("left", "right")


def cameras(folder, **settings):
    return {
        name: FolderCameraSettings(folder=str(folder), pattern=f"*_{name}.jpg", **settings) for name in NAMES
    }


def numbers(sets):
    return [[frame.number for frame in frame_set.frames] for frame_set in sets]


def test_pictures_pair_by_their_numbers_though_some_are_missing(tmp_path, jpeg, played) -> None:
    for name, present in (("left", (0, 2, 7, 10)), ("right", (2, 3, 7, 10, 11))):
        for number in present:
            (tmp_path / f"{number:03}_{name}.jpg").write_bytes(jpeg(number + (name == "right")))
    sets = played(cameras(tmp_path))
    assert numbers(sets) == [[2, 2], [7, 7], [10, 10]]
    assert [frame.jpeg for frame in sets[1].frames] == [jpeg(7), jpeg(8)]


def test_pictures_without_common_numbers_pair_by_their_order(tmp_path, jpeg, played) -> None:
    for name, present in (("left", "abc"), ("right", "xyz")):
        for letter in present:
            (tmp_path / f"{letter}_{name}.jpg").write_bytes(jpeg(ord(letter)))
    assert numbers(played(cameras(tmp_path))) == [[0, 0], [1, 1], [2, 2]]


def test_pictures_that_pair_by_their_order_must_be_as_many(tmp_path, jpeg) -> None:
    for name, present in (("left", "abc"), ("right", "xy")):
        for letter in present:
            (tmp_path / f"{letter}_{name}.jpg").write_bytes(jpeg(ord(letter)))
    with pytest.raises(CameraError, match="3 of camera left and 2 of camera right: give those"):
        file_cameras(cameras(tmp_path), paced=False)


def test_dates_as_names_take_no_longer_than_other_pictures(tmp_path, jpeg, played) -> None:
    for number in (1_769_000_000_000_000_000, 1_769_000_100_000_000_000):
        for name in NAMES:
            (tmp_path / f"{number}_{name}.jpg").write_bytes(jpeg(1))
    first, second = played(cameras(tmp_path, rate_hz=20.0))
    assert second.capture_monotonic_ns - first.capture_monotonic_ns == 50_000_000


def test_other_pictures_become_jpeg_without_a_visible_loss(tmp_path, jpeg, played) -> None:
    shown = cv2.imdecode(np.frombuffer(jpeg(5), np.uint8), cv2.IMREAD_COLOR)
    cv2.imwrite(str(tmp_path / "5.png"), shown)
    (frame,) = played({"left": FolderCameraSettings(folder=str(tmp_path))})[0].frames
    assert frame.jpeg.startswith(b"\xff\xd8")
    seen = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(seen.astype(int) - shown).max() <= 3


def test_a_file_that_is_no_picture_is_named_and_left_out(tmp_path, jpeg, played, caplog) -> None:
    (tmp_path / "1.png").write_bytes(b"no picture")
    (tmp_path / "2.jpg").write_bytes(jpeg(2))
    assert numbers(played({"left": FolderCameraSettings(folder=str(tmp_path))})) == [[2]]
    assert "1.png: not a picture" in caplog.text


def test_what_cannot_be_played_is_refused_by_name(tmp_path, jpeg) -> None:
    def refused(settings, words):
        with pytest.raises(CameraError, match=words):
            file_cameras(settings, paced=False)

    refused(cameras(tmp_path / "away"), "camera left: there is no folder .*away")
    (tmp_path / "1_left.txt").touch()
    refused(
        cameras(tmp_path), r"camera left: no picture in .* matches '\*_left.jpg'; pictures end in .*\.png"
    )
    refused({"left": FolderCameraSettings(folder=str(tmp_path), pattern="/x")}, "pattern '/x'")
    for name in NAMES:
        (tmp_path / f"1_{name}.jpg").write_bytes(jpeg(1))
    refused(cameras(tmp_path) | {"right": cameras(tmp_path, rate_hz=5.0)["right"]}, r"rates \[5.0, 30.0\] Hz")


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (["007_left", "010_left"], [7, 10]),
        (["cam2_0007", "cam2_0008"], [7, 8]),
        (["7_of_9", "8_of_9"], [7, 8]),
        (["2_0008", "3_0007"], [8, 7]),
        (["left", "left2"], None),
        (["1_1", "1_1b"], None),
        ([], None),
    ],
)
def test_the_number_in_a_name_is_the_one_that_tells_it_from_the_others(names, numbers) -> None:
    assert numbers_in(names) == numbers


@given(st.dictionaries(st.sampled_from("abc"), st.sets(st.integers(0, 50), min_size=1), min_size=1))
def test_numbers_are_kept_where_all_cameras_share_some(present) -> None:
    names = {
        camera: [f"{camera}_{number:04}" for number in sorted(those)] for camera, those in present.items()
    }
    if set.intersection(*present.values()):
        assert together(names) == {camera: sorted(those) for camera, those in present.items()}
    elif len({len(those) for those in present.values()}) == 1:
        assert together(names) == {camera: list(range(len(those))) for camera, those in present.items()}
    else:
        with pytest.raises(CameraError, match="no number in common"):
            together(names)
