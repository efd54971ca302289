"""Coded pictures that can be told apart, and playing cameras to their end."""

import cv2
import numpy as np
import pytest

from drivers.cameras import FrameSetPairing
from drivers.cameras.files.opening import file_cameras


def picture(number, size_px=(64, 48)):
    width, height = size_px
    levels = np.add.outer(np.arange(height), np.arange(width)) % 200
    return np.dstack([levels, np.full_like(levels, number % 250), levels[::-1]]).astype(np.uint8)


@pytest.fixture
def jpeg():
    """A JPEG for each number, never the same for two."""
    return lambda number: cv2.imencode(".jpg", picture(number))[1].tobytes()


@pytest.fixture
def played():
    """Every frame set of these settings, played as fast as they can be read."""

    def play(settings, maximum_skew_s=0.005):
        cameras = file_cameras(settings, paced=False)
        pairing = FrameSetPairing(tuple(settings), maximum_skew_s)
        sets = []
        while not all(camera.ended for camera in cameras):
            frames = [frame for camera in cameras if (frame := camera.read()) is not None]
            sets += [complete for frame in frames if (complete := pairing.feed(frame)) is not None]
        return sets

    return play
