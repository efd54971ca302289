"""Frames of cameras, as many as their judgement needs."""

import time
from collections import deque
from collections.abc import Sequence

from drivers.cameras import Camera, CameraFrame, SilenceWatch

SETTLING = 5
"""A camera's first frames, which it needs to get going; they are kept only where there are no others."""
POLL_S = 0.002


def take(cameras: Sequence[Camera], count: int, silence_s: float) -> dict[str, list[CameraFrame]]:
    """The `count` newest of `count` and a few frames of each camera; fewer of a file that is shorter.

    Raises CameraSilentError naming the cameras that gave nothing for `silence_s`.
    """
    kept: dict[str, deque[CameraFrame]] = {camera.name: deque(maxlen=count) for camera in cameras}
    left = dict.fromkeys(kept, count + SETTLING)
    watch = SilenceWatch(kept, silence_s, time.monotonic())
    while waited := [camera for camera in cameras if left[camera.name] > 0 and not camera.ended]:
        frames = [frame for camera in cameras if (frame := camera.read()) is not None]
        for frame in frames:
            kept[frame.name].append(frame)
            left[frame.name] -= 1
        now_s = time.monotonic()
        for name in kept.keys() - {camera.name for camera in waited} | {frame.name for frame in frames}:
            watch.heard(name, now_s)
        watch.check(now_s)
        if not frames:
            time.sleep(POLL_S)
    return {name: list(frames) for name, frames in kept.items()}
