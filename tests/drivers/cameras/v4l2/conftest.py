"""Webcams that stand in below the V4L2 calls; linuxpy and the driver run on them as they are."""

import functools

import cv2
import numpy as np
import pytest

from drivers.cameras import V4l2CameraSettings
from drivers.cameras.v4l2 import camera as driver
from drivers.cameras.v4l2.camera import V4l2Camera
from drivers.simulated.v4l2 import StandInCamera, plugged_in

SIZE = (640, 480)


@pytest.fixture(scope="session")
def pictures():
    noise = np.random.default_rng(7).integers(0, 255, (3, 48, 64, 3), dtype=np.uint8)
    enlarged = (cv2.resize(one, SIZE, interpolation=cv2.INTER_NEAREST) for one in noise)
    return [cv2.imencode(".jpg", one)[1].tobytes() for one in enlarged]


@pytest.fixture
def impatient(monkeypatch):
    """A stream without pictures is given up soon."""
    monkeypatch.setattr(driver, "START_S", 0.6)
    monkeypatch.setattr(driver, "STILL_S", 0.3)
    monkeypatch.setattr(driver, "STILL_PICTURES", 3)


@pytest.fixture
def soon_again(monkeypatch):
    """A camera that was lost is looked for at once."""
    monkeypatch.setattr(driver, "RETRY_S", 0.02)


@pytest.fixture
def webcam(pictures):
    """Plugged in; it takes pictures when it is told to."""
    camera = StandInCamera(pictures, running=False)
    with plugged_in(camera):
        yield camera


@pytest.fixture
def running_webcam(pictures):
    """Plugged in; it takes pictures by its own clock."""
    camera = StandInCamera(pictures)
    with plugged_in(camera):
        yield camera


@pytest.fixture
def settings():
    return functools.partial(V4l2CameraSettings, width_px=SIZE[0], height_px=SIZE[1])


@pytest.fixture
def opened(settings):
    """Open the camera as `left`; closed at the end of the test."""
    cameras = []

    def _open(webcam, **how):
        cameras.append(V4l2Camera("left", settings(device=str(webcam.path), **how)))
        return cameras[-1]

    yield _open
    for camera in cameras:
        camera.close()


@pytest.fixture
def taken(eventually):
    """Let a camera take a picture, and read it."""

    def _taken(webcam, camera, **how):
        webcam.expose(**how)
        return eventually(camera.read)

    return _taken
