"""The driver of a simulated camera on a real bus, and the watch for silent cameras."""

import socket
import time

import msgspec
import pytest

from drivers.cameras import (
    CameraSettings,
    CameraSilentError,
    SilenceWatch,
    SimulatedCameraSettings,
    UnknownCameraError,
    open_cameras,
)
from messaging.frames import Frame
from messaging.session import open_rendezvous, open_session
from messaging.settings import ZenohSettings
from messaging.topics import SIMULATED_CAMERA


@pytest.fixture
def zenoh():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return ZenohSettings(rendezvous=f"tcp/127.0.0.1:{port}")


def newest_of(camera, wanted: int, deadline_s: float = 10.0):
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        frame = camera.read()
        if frame is not None and frame.number == wanted:
            return frame
        time.sleep(0.002)
    raise AssertionError(f"frame {wanted} did not come")


def test_the_newest_frame_is_read_once_with_its_number_and_time(zenoh) -> None:
    with (
        open_rendezvous(zenoh, "cameras"),
        open_session(zenoh, "cameras", "bench") as bench,
        open_session(zenoh, "cameras", "driver") as driver,
        open_cameras({"left": SimulatedCameraSettings()}, driver) as (camera,),
    ):
        publisher = bench.publisher(SIMULATED_CAMERA.named("left"))
        end = time.monotonic() + 10
        number = 0
        while camera.read() is None:
            assert time.monotonic() < end
            publisher.put(Frame(camera="left", capture_time_ns=number, jpeg=b"warm"), number)
            number += 1
            time.sleep(0.01)
        for last in range(1000, 1003):
            publisher.put(Frame(camera="left", capture_time_ns=77 + last, jpeg=b"picture"), last)
        frame = newest_of(camera, 1002)
        assert (frame.name, frame.jpeg, frame.capture_monotonic_ns) == ("left", b"picture", 1079)
        assert camera.read() is None


def test_settings_name_their_kind() -> None:
    assert msgspec.convert({"source": "simulated"}, CameraSettings) == SimulatedCameraSettings()
    with pytest.raises(msgspec.ValidationError, match="webcam"):
        msgspec.convert({"source": "webcam"}, CameraSettings)
    with pytest.raises(msgspec.ValidationError, match="gain"):
        msgspec.convert({"source": "simulated", "gain": 3}, CameraSettings)


def test_a_silent_camera_is_named_and_one_that_speaks_is_not() -> None:
    watch = SilenceWatch(("left", "right"), 0.2, now_s=10.0)
    watch.heard("left", 10.3)
    with pytest.raises(CameraSilentError, match=r"right for 0\.40 s; allowed are 0\.2 s") as raised:
        watch.check(10.4)
    assert "left" not in str(raised.value)
    watch.heard("right", 10.4)
    watch.check(10.45)
    with pytest.raises(UnknownCameraError, match="camera top is not one of left, right"):
        watch.heard("top", 11.0)
