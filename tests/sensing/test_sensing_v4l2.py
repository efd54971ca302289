"""Sensing on webcams: two stand in below the V4L2 calls, each showing real pictures of the robot by its own clock."""

import threading
import time

import pytest
from linuxpy.video.raw import PixelFormat

from drivers.cameras import V4l2CameraSettings, open_cameras
from drivers.cameras.frame_sets import frame_sets
from drivers.cameras.v4l2 import camera as driver
from drivers.simulated.v4l2 import StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CameraDescription
from messaging import topics
from messaging.session import open_rendezvous, open_session
from messaging.settings import RobotSettings
from sensing.process import run
from sensing.settings import NodalPointSetting, SensingSettings

POSE = (0.5, 0.4, 0.3, 0.4)
RATE_HZ = 10
HALF_A_PERIOD_S = 0.05
SETTINGS = SensingSettings(
    nodal_points=(NodalPointSetting(name="tip", arc_mm=80.0),), maximum_skew_s=HALF_A_PERIOD_S
)


@pytest.fixture
def webcams(small_bench, arcs):
    """The bench's two cameras as webcams, looking at the robot."""
    seen = [small_bench.photograph(arcs(*POSE)) for _ in range(3)]
    webcams = {
        camera.camera: StandInCamera(
            [pictures[camera.camera] for pictures in seen],
            CameraDescription(
                usb_port=str(port),
                formats={PixelFormat.MJPEG: {(camera.width_px, camera.height_px): (30, RATE_HZ)}},
            ),
        )
        for port, camera in enumerate(small_bench.rig)
    }
    with plugged_in(*webcams.values()):
        yield webcams


@pytest.fixture
def settings(small_bench, webcams):
    return {
        camera.camera: V4l2CameraSettings(
            device=str(webcams[camera.camera].path),
            width_px=camera.width_px,
            height_px=camera.height_px,
            rate_hz=RATE_HZ,
        )
        for camera in small_bench.rig
    }


def test_frame_sets_hold_the_webcams_own_bytes(webcams, settings, zenoh_settings):
    with (
        open_rendezvous(zenoh_settings, "webcams"),
        open_session(zenoh_settings, "webcams", "sensing") as session,
        open_cameras(settings, session) as cameras,
    ):
        sets = frame_sets(cameras, maximum_skew_s=HALF_A_PERIOD_S, silence_s=10.0)
        first = next(one for one in sets if one is not None)
    assert [frame.name for frame in first.frames] == list(webcams)
    assert all(frame.jpeg == webcams[frame.name].buffers.sent[frame.number] for frame in first.frames)
    assert abs(first.capture_monotonic_ns - time.monotonic_ns()) < 10e9


def test_a_shape_is_sensed_and_again_after_a_cable_was_out(
    small_bench, arcs, webcams, settings, zenoh_settings, monkeypatch, eventually
):
    monkeypatch.setattr(driver, "RETRY_S", 0.02)
    stop = threading.Event()
    right = list(webcams.values())[1]
    with (
        open_rendezvous(zenoh_settings, "webcams"),
        open_session(zenoh_settings, "webcams", "sensing") as inner,
        open_session(zenoh_settings, "webcams", "outside") as outer,
    ):
        frames = outer.newest(topics.CAMERA.named("right"))
        shapes = outer.newest(topics.SHAPE)

        def shape_since(moment_ns):
            taken = shapes.take()
            return taken[0] if taken and taken[0].capture_time_ns > moment_ns else None

        sensing = threading.Thread(
            target=run,
            args=(
                SETTINGS,
                RobotSettings(section_length_mm=(40.0, 40.0)),
                small_bench.rig,
                {},
                settings,
                inner,
                stop,
                lambda: None,
            ),
        )
        sensing.start()
        try:
            estimate = eventually(lambda: shape_since(0))
            assert estimate.refusal == ""
            assert estimate.node_mm[0] == pytest.approx(arcs(*POSE)[80], abs=1.0)
            frame, _ = eventually(frames.take)
            assert frame.jpeg in right.buffers.sent.values()
            right.pull_out()
            right.plug_in()
            eventually(lambda: right.starts == 2)
            back_ns = time.time_ns()
            assert eventually(lambda: shape_since(back_ns)).refusal == ""
        finally:
            stop.set()
            sensing.join()
