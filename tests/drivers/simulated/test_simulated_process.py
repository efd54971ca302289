"""The whole simulated bench as a process: frames, truth, the serial device, and what is left when it dies."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from drivers.cameras import FrameSetPairing, SimulatedCameraSettings, open_cameras
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.settings import SimulationSettings
from messaging import topics
from messaging.scene import Scene, SceneRequest
from messaging.session import open_rendezvous, open_session
from messaging.settings import ZenohSettings

BENCH = """
import dataclasses, signal, sys, threading
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.process import run
from drivers.simulated.servos.settings import EmulatedServosSettings
from drivers.simulated.settings import SimulationSettings
from messaging.board import BoardPlace, BoardSettings
from messaging.session import open_session
from messaging.settings import ZenohSettings

BOARD = BoardSettings(at_base=BoardPlace(origin_mm=(-45, 0, 77), x_axis=(1, 0, 0), y_axis=(0, 0, -1)))
zenoh, link = ZenohSettings(rendezvous=sys.argv[1]), sys.argv[2]
stop = threading.Event()
signal.signal(signal.SIGTERM, lambda *_: stop.set())
settings = SimulationSettings(servos=EmulatedServosSettings(link=link, ids=(1, 2, 3, 4, 5)))
cameras = tuple(
    dataclasses.replace(
        camera, width_px=640, height_px=360, intrinsics=camera.intrinsics * [[1 / 3], [1 / 3], [1]]
    )
    for camera in default_cameras()
)
with open_session(zenoh, "sim", "simulate") as session:
    run(settings, cameras, zenoh, "sim", BOARD, session, stop, lambda: None)
"""


@pytest.fixture(scope="module")
def zenoh():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    settings = ZenohSettings(rendezvous=f"tcp/127.0.0.1:{port}")
    with open_rendezvous(settings, "sim"):
        yield settings


@pytest.fixture(scope="module")
def session(zenoh):
    with open_session(zenoh, "sim", "test") as session:
        yield session


@pytest.fixture
def start(zenoh, tmp_path):
    running = []

    def start_bench() -> subprocess.Popen:
        bench = subprocess.Popen([sys.executable, "-c", BENCH, zenoh.rendezvous, str(tmp_path / "servos")])
        running.append(bench)
        return bench

    yield start_bench
    for bench in running:
        bench.kill()
        bench.wait()


def until(condition, deadline_s: float = 40.0):
    end = time.monotonic() + deadline_s
    while not (found := condition()):
        assert time.monotonic() < end, "did not come in time"
        time.sleep(0.002)
    return found


def children(process: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def frame_sets(cameras, count: int) -> list:
    pairing = FrameSetPairing(("left", "right"), 0.01)
    sets: list = []

    def enough() -> bool:
        frames = [frame for camera in cameras if (frame := camera.read()) is not None]
        sets.extend(complete for frame in frames if (complete := pairing.feed(frame)) is not None)
        return len(sets) >= count

    until(enough)
    return sets


def test_a_bench_lives_dies_and_comes_back(start, session, tmp_path) -> None:
    names = [camera.camera for camera in default_cameras()]
    truths = session.every(topics.TRUTH, 1000)
    with open_cameras(dict.fromkeys(names, SimulatedCameraSettings()), session) as cameras:
        bench = start()
        sets = frame_sets(cameras, 8)
        assert (tmp_path / "servos").is_symlink()
        assert all(frame_set.skew_s < 0.0075 for frame_set in sets)
        picture = cv2.imdecode(np.frombuffer(sets[-1].frames[0].jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert picture.shape == (360, 640, 3)
        truth_times = []
        while (truth := truths.take()) is not None:
            message = topics.Truth.from_bytes(truth.payload)
            assert np.linalg.norm(np.diff(message.centreline_mm, axis=0), axis=1).sum() == pytest.approx(
                80, abs=0.1
            )
            truth_times.append(message.capture_time_ns)
        unix_from_monotonic_ns = time.time_ns() - time.monotonic_ns()
        nearest = [
            np.abs(np.array(truth_times) - frame_set.capture_monotonic_ns - unix_from_monotonic_ns).min()
            for frame_set in sets[:-1]
        ]
        assert max(nearest) < 1_000_000

        renderers = children(bench.pid)
        assert len(renderers) == 2
        bench.send_signal(signal.SIGKILL)
        bench.wait()
        until(lambda: not any(Path(f"/proc/{renderer}").exists() for renderer in renderers), 10)
        assert (tmp_path / "servos").is_symlink()

        again = start()
        assert frame_sets(cameras, 3)
        assert (tmp_path / "servos").exists()
        again.send_signal(signal.SIGTERM)
        assert again.wait(10) == 0
        assert not (tmp_path / "servos").is_symlink()


def test_a_bench_whose_camera_dies_ends_with_an_error_that_names_it(start, session) -> None:
    bench = start()
    with open_cameras({"right": SimulatedCameraSettings()}, session) as (camera,):
        until(camera.read)
        os.kill(children(bench.pid)[1], signal.SIGKILL)
        assert bench.wait(10) != 0


def decoded(frame):
    return cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)


def white_px(frame) -> int:
    """How much of the picture is as bright in all colours as only paper is."""
    return int((decoded(frame).min(axis=2) > 80).sum())


def test_a_scene_is_answered_when_its_pictures_have_come_and_has_no_truth_without_the_robot(
    start, session
) -> None:
    def ask(scene: Scene):
        return session.ask(topics.SIMULATION_SCENE, SceneRequest(scene=scene), 40.0)

    truths = session.newest(topics.TRUTH)
    newest = [session.newest(topics.SIMULATED_CAMERA.named(name)) for name in ("left", "right")]
    start()
    white = {}
    for scene in (Scene.ROBOT, Scene.EMPTY, Scene.BOARD_AT_BASE, Scene.BOARD):
        reply = ask(scene)
        assert reply.accepted, reply.reason
        assert reply.state == scene
        # whatever comes last before the answer is of the scene already
        white[scene] = [white_px(ring.take()[0]) for ring in newest]
    assert max(white[Scene.ROBOT] + white[Scene.EMPTY]) < 500, white
    assert min(white[Scene.BOARD_AT_BASE] + white[Scene.BOARD]) > 2000, white
    truths.take()
    for _ in range(5):
        until(newest[0].take)
    assert truths.take() is None
    assert ask(Scene.ROBOT).accepted
    until(truths.take)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"servos": {"link": "x", "ids": [1, 2, 3]}},
            "4 tendon pairs, so 4 ids are needed, and the stage's if",
        ),
        (
            {"cameras": {"body": {"diameter_mm": [6.0]}}},
            "one colour for each|one for each of the robot's 2 sections|colours",
        ),
        (
            {"drive": {"each_pulley_mm_per_rad": [5.0, -5.0]}},
            r"one for each of the 4 pulleys, or none",
        ),
        ({"speed": 3}, "unknown field `speed`"),
        ({"step_rate_hz": 5}, ">= 50"),
    ],
)
def test_settings_that_cannot_be_are_refused(change, message) -> None:
    table = {"servos": {"link": "x", "ids": [1, 2, 3, 4, 5]}} | change
    with pytest.raises(msgspec.ValidationError, match=message):
        msgspec.convert(table, SimulationSettings)
