"""What a V4L2 camera hands on: its own bytes, the kernel's times, and numbers that show what is missing."""

import logging
import time

import pytest
from linuxpy.video.raw import BufferFlag

from drivers.cameras import CameraFormatError, V4l2Controls
from drivers.cameras.v4l2.camera import V4l2Camera
from drivers.cameras.v4l2.inspection import PictureFault

EXPOSURE_S = 0.01
HALF_NS = 5_000_000


def test_the_cameras_own_bytes_come_untouched_in_their_order(webcam, opened, taken):
    camera = opened(webcam)
    frames = [taken(webcam, camera) for _ in range(6)]
    assert [frame.jpeg for frame in frames] == list(webcam.buffers.sent.values())
    assert [frame.number for frame in frames] == list(range(6))
    assert {frame.name for frame in frames} == {"left"}


def test_reading_returns_at_once_and_gives_the_newest_few(webcam, opened, eventually):
    camera = opened(webcam)
    assert camera.read() is None
    for _ in range(10):
        webcam.expose()
        eventually(lambda: not webcam.buffers.is_waiting)
    # so that nothing comes any more
    camera.close()
    assert [camera.read().number for _ in range(2)] == [8, 9]
    assert camera.read() is None
    assert not camera.ended


@pytest.mark.parametrize(
    ("source", "offset_ns"), [(BufferFlag.TSTAMP_SRC_SOE, HALF_NS), (BufferFlag.TSTAMP_SRC_EOF, -HALF_NS)]
)
def test_a_frames_time_is_the_middle_of_its_exposure(webcam, opened, taken, eventually, source, offset_ns):
    webcam.buffers.flags = BufferFlag.TIMESTAMP_MONOTONIC | source
    camera = opened(webcam, controls=V4l2Controls(exposure_s=EXPOSURE_S))
    taken_ns = time.monotonic_ns() + 123_456
    eventually(lambda: time.monotonic_ns() > taken_ns + HALF_NS)
    frame = taken(webcam, camera, timestamp_ns=taken_ns)
    # V4L2 counts in microseconds
    assert frame.capture_monotonic_ns == taken_ns // 1000 * 1000 + offset_ns


def test_no_frame_is_of_later_than_it_came(webcam, opened, taken):
    frame = taken(webcam, opened(webcam, controls=V4l2Controls(exposure_s=0.2)))
    assert frame.capture_monotonic_ns <= time.monotonic_ns()


def test_a_driver_that_stamps_by_another_clock_is_refused(webcam, opened):
    webcam.buffers.flags = int(BufferFlag.TIMESTAMP_COPY)
    with pytest.raises(CameraFormatError, match=r"camera left: .* monotonic clock"):
        opened(webcam)


def test_a_driver_whose_stamps_are_not_of_the_clock_that_it_says_is_named(webcam, opened, eventually, caplog):
    camera = opened(webcam)
    webcam.expose(timestamp_ns=time.monotonic_ns() + 1_000_000_000_000)
    eventually(
        lambda: "camera left: its driver does not stamp pictures by the monotonic clock" in caplog.text
    )
    assert camera.read() is None


def test_pictures_lost_on_the_way_are_counted_and_leave_a_gap(webcam, opened, taken, caplog):
    camera = opened(webcam)
    taken(webcam, camera)
    assert taken(webcam, camera, lost_before=3).number == 4
    assert camera.faults == {PictureFault.LOST: 3}
    assert "camera left: pictures left out: 3 lost on the way" in caplog.text


def test_pictures_from_before_everything_was_locked_are_left_out(webcam, opened, taken, eventually):
    camera = opened(webcam)
    webcam.expose(timestamp_ns=time.monotonic_ns() - 10_000_000_000)
    frame = taken(webcam, camera)
    assert frame.jpeg == webcam.buffers.sent[1]


def test_a_closed_camera_is_free_for_others(webcam, opened, taken):
    opened(webcam).close()
    taken(webcam, opened(webcam))
    assert webcam.starts == 2


def test_what_is_locked_stands_in_the_log(webcam, opened, caplog):
    caplog.set_level(logging.INFO)
    opened(webcam, controls=V4l2Controls(exposure_s=0.005, focus=40))
    assert "camera left: C922 Pro Stream Webcam, locked at exposure_s 0.005, gain 0, focus 40" in caplog.text


def test_a_name_that_does_not_last_is_warned_of(webcam, opened, settings, caplog):
    opened(webcam).close()
    assert "may be another camera" not in caplog.text
    node = webcam.files.nodes[0]
    V4l2Camera("left", settings(device=str(node))).close()
    assert f"{node} may be another camera after a restart; {webcam.path} stays" in caplog.text
