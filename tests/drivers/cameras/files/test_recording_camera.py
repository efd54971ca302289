"""Recordings as cameras: frames with their own times, as far as a recording goes."""

from pathlib import Path

import pytest

from drivers.cameras import CameraError, RecordingCameraSettings
from drivers.cameras.files.opening import file_cameras
from messaging import topics
from recordings.log import Log

RUN = Path(__file__).parents[3] / "data" / "run.mcap"
NAMES = ("left", "right")
SKEW_S = 0.02


def cameras(file):
    return {name: RecordingCameraSettings(file=str(file)) for name in NAMES}


def test_frames_are_those_of_the_log_in_its_sets_and_at_its_times(played) -> None:
    logged = {name: [] for name in NAMES}
    for recorded in Log(RUN).messages((topics.CAMERA,)):
        frame = recorded.message
        logged[frame.camera].append((recorded.sequence, frame.jpeg, frame.capture_time_ns))
    sets = played(cameras(RUN), SKEW_S)
    begun_ns = sets[0].frames[0].capture_monotonic_ns - logged["left"][0][2]
    for column, name in enumerate(NAMES):
        frames = [frame_set.frames[column] for frame_set in sets]
        assert [
            (frame.number, frame.jpeg, frame.capture_monotonic_ns - begun_ns) for frame in frames
        ] == logged[name]


def test_a_recording_that_was_cut_off_is_read_up_to_there(tmp_path, played, caplog) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(RUN.read_bytes()[: RUN.stat().st_size // 2])
    sets = played(cameras(cut), SKEW_S)
    assert 20 < len(sets) < len(played(cameras(RUN), SKEW_S))
    assert "cut.mcap is damaged or cut off" in caplog.text


def test_a_recording_that_is_damaged_inside_is_read_up_to_there(tmp_path, played, caplog) -> None:
    data = bytearray(RUN.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 2000] = bytes(2000)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    assert 20 < len(played(cameras(damaged), SKEW_S)) < 150
    assert "damaged.mcap is damaged or cut off" in caplog.text


def test_a_camera_may_have_another_name_in_the_recording(played) -> None:
    settings = {"front": RecordingCameraSettings(file=str(RUN), camera="right")}
    (frame,) = played(settings)[0].frames
    assert frame.name == "front"
    assert frame.jpeg == played(cameras(RUN), SKEW_S)[0].frames[1].jpeg


def test_what_is_no_recording_of_this_camera_is_refused_by_name(tmp_path) -> None:
    def refused(file, words):
        with pytest.raises(CameraError, match=words):
            file_cameras({"top": RecordingCameraSettings(file=str(file))}, paced=False)

    refused(RUN, "run.mcap: no frame of camera top can be read; cameras in it: left, right")
    refused(tmp_path / "away.mcap", "away.mcap: cannot be read: No such file")
    (tmp_path / "text.mcap").write_text("not a recording, though it is long enough for one")
    refused(tmp_path / "text.mcap", "text.mcap: not a recording")
