"""Playing files: in step, in real time or not, and to an end."""

import time

from drivers.cameras import CameraError, FolderCameraSettings, open_cameras
from drivers.cameras.files.picture import FilePicture
from drivers.cameras.files.playback import WAITING_AT_MOST, Playback

MS = 1_000_000


def track(offsets_ns, jpeg=lambda: b"jpeg"):
    return iter(
        [FilePicture(offset_ns=offset, number=number, jpeg=jpeg) for number, offset in enumerate(offsets_ns)]
    )


def read_all(cameras):
    order = []
    while not all(camera.ended for camera in cameras):
        order += [(frame.name, frame.number) for camera in cameras if (frame := camera.read()) is not None]
    return order


def test_no_camera_runs_ahead_of_another() -> None:
    playback = Playback({"a": track([0, 10, 20, 1000]), "b": track([995, 1000, 2000])}, paced=False)
    assert read_all(playback.cameras) == [
        ("a", 0), ("a", 1), ("a", 2), ("b", 0), ("a", 3), ("b", 1), ("b", 2)
    ]  # fmt: skip


def test_in_real_time_a_frame_is_read_when_its_time_has_come(eventually) -> None:
    (camera,) = Playback({"a": track([5 * MS, 35 * MS, 65 * MS])}, paced=True).cameras
    frames = []
    while not camera.ended:
        frame = eventually(lambda: camera.read() or camera.ended)
        if frame is not True:
            assert frame.capture_monotonic_ns <= time.monotonic_ns()
            frames.append(frame)
    assert [frame.capture_monotonic_ns - frames[0].capture_monotonic_ns for frame in frames] == [
        0,
        30 * MS,
        60 * MS,
    ]


def test_who_reads_late_misses_all_but_the_newest_frames(eventually) -> None:
    read = []
    (camera,) = Playback({"a": track([0] * 20, lambda: read.append(1) or b"jpeg")}, paced=True).cameras
    numbers = [frame.number for frame in iter(camera.read, None)]
    assert numbers == list(range(20))[-WAITING_AT_MOST:]
    assert len(read) == WAITING_AT_MOST
    assert camera.ended


def test_a_picture_that_cannot_be_read_is_logged_and_the_next_one_comes(caplog) -> None:
    def broken():
        raise CameraError("shot.png: not a picture")

    pictures = [
        FilePicture(offset_ns=number, number=number, jpeg=broken if number == 1 else bytes)
        for number in range(3)
    ]
    assert read_all(Playback({"a": iter(pictures)}, paced=False).cameras) == [("a", 0), ("a", 2)]
    assert "camera a: shot.png: not a picture" in caplog.text


def test_cameras_open_in_their_order_and_let_their_files_go(tmp_path, jpeg) -> None:
    for number in range(2):
        (tmp_path / f"{number}.jpg").write_bytes(jpeg(number))
    settings = {name: FolderCameraSettings(folder=str(tmp_path)) for name in ("b", "a")}
    with open_cameras(settings, session=None, paced=False) as cameras:
        assert [camera.name for camera in cameras] == ["b", "a"]
        assert cameras[0].read().jpeg == jpeg(0)
    assert all(camera.ended for camera in cameras)
