"""MJPEG videos: the very bytes that the camera coded, at the video's rate."""

import struct

import cv2
import numpy as np
import pytest

from drivers.cameras import AviCameraSettings, CameraError, FolderCameraSettings
from drivers.cameras.files.opening import file_cameras

SIZE_PX = 64, 48


def chunk(kind, *parts):
    content = b"".join(parts)
    return kind + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def avi(pictures, rate_hz):
    """A RIFF AVI file (Microsoft, "AVI RIFF File Reference") around these JPEGs, which it holds as they are."""
    period_us, (width, height), longest = round(1e6 / rate_hz), SIZE_PX, max(map(len, pictures))
    main = struct.pack("<10I16x", period_us, 0, 0, 0x10, len(pictures), 0, 1, longest, width, height)
    stream = struct.pack(
        "<4s4sIHHIIIIIIIIHHHH",
        b"vids",
        b"MJPG",
        0,
        0,
        0,
        0,
        1,
        rate_hz,
        0,
        len(pictures),
        longest,
        0,
        0,
        0,
        0,
        width,
        height,
    )
    bitmap = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 24, b"MJPG", width * height * 3, 0, 0, 0, 0)
    header = chunk(
        b"LIST",
        b"hdrl",
        chunk(b"avih", main),
        chunk(b"LIST", b"strl", chunk(b"strh", stream), chunk(b"strf", bitmap)),
    )
    frames = [chunk(b"00dc", picture) for picture in pictures]
    places, at = [], 4
    for picture, frame in zip(pictures, frames, strict=True):
        places.append(struct.pack("<4sIII", b"00dc", 0x10, at, len(picture)))
        at += len(frame)
    return chunk(b"RIFF", b"AVI ", header, chunk(b"LIST", b"movi", *frames), chunk(b"idx1", *places))


def test_pictures_are_the_bytes_in_the_file_at_its_rate(tmp_path, jpeg, played) -> None:
    pictures = {
        "left": [jpeg(number) for number in range(5)],
        "right": [jpeg(number + 50) for number in range(5)],
    }
    settings = {name: AviCameraSettings(file=str(tmp_path / f"{name}.avi")) for name in pictures}
    for name, those in pictures.items():
        (tmp_path / f"{name}.avi").write_bytes(avi(those, 25))
    sets = played(settings)
    for column, those in enumerate(pictures.values()):
        assert [frame_set.frames[column].jpeg for frame_set in sets] == those
    assert [frame_set.frames[0].number for frame_set in sets] == list(range(5))
    assert set(np.diff([frame_set.capture_monotonic_ns for frame_set in sets])) == {40_000_000}


def test_a_video_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path, jpeg, played) -> None:
    pictures = [jpeg(number) for number in range(5)]
    whole = avi(pictures, 25)
    (tmp_path / "cut.avi").write_bytes(whole[: whole.rindex(pictures[3]) + 100])
    sets = played({"left": AviCameraSettings(file=str(tmp_path / "cut.avi"))})
    assert [frame_set.frames[0].jpeg for frame_set in sets][:3] == pictures[:3]


def test_other_videos_and_files_are_refused_by_name(tmp_path, jpeg) -> None:
    def refused(file, words):
        with pytest.raises(CameraError, match=words):
            file_cameras({"left": AviCameraSettings(file=str(file))}, paced=False)

    refused(tmp_path / "away.avi", "away.avi: there is no such video")
    (tmp_path / "text.avi").write_text("not a video")
    refused(tmp_path / "text.avi", "text.avi: not a video")
    writer = cv2.VideoWriter(
        str(tmp_path / "other.mp4"), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"mp4v"), 25, SIZE_PX
    )
    writer.write(cv2.imdecode(np.frombuffer(jpeg(1), np.uint8), cv2.IMREAD_COLOR))
    writer.release()
    refused(tmp_path / "other.mp4", "other.mp4: its pictures are coded as 'FMP4'; allowed is 'MJPG'")


def test_files_of_several_kinds_have_no_time_in_common(tmp_path) -> None:
    with pytest.raises(CameraError, match="cameras left, right are files of the kinds avi, folder"):
        file_cameras(
            {"left": AviCameraSettings(file="a.avi"), "right": FolderCameraSettings(folder=str(tmp_path))},
            paced=False,
        )
