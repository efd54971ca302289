"""Pictures of a bench without hardware: the part around the robot of a frame that the repository keeps."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from messaging import topics
from recordings.log import Log

PHOTOGRAPHS = Path(__file__).parents[2] / "data" / "photographs.mcap"


@pytest.fixture(scope="session")
def scene():
    """A robot before a backdrop, BGR (540, 960, 3)."""
    frame = next(iter(Log(PHOTOGRAPHS).messages((topics.CAMERA.named("left"),)))).message
    picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)
    return picture[100:640, 480:1440]


@pytest.fixture(scope="session")
def coded():
    """A picture as a camera codes it, with noise of so many levels."""

    def code(picture, noise_levels=1.0, seed=0):
        noise = np.random.default_rng(seed).normal(0, noise_levels, picture.shape)
        levels = np.clip(picture + noise, 0, 255).astype(np.uint8)
        return cv2.imencode(".jpg", levels, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()

    return code
