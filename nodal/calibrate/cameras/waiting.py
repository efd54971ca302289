"""Why no frame set comes, for the person who waits for one with a board in the hand."""

import time
from collections.abc import Sequence

from drivers.cameras import Camera, CameraFrame

PATIENCE_S = 2.0
"""Cameras that run may well give nothing for so long."""
MS_PER_S = 1000


class HeardCamera:
    """A camera, and when it last gave a frame."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self.heard_s: float | None = None

    @property
    def name(self) -> str:
        """Its name on the bench."""
        return self._camera.name

    @property
    def ended(self) -> bool:
        """Whether it will never give another frame."""
        return self._camera.ended

    def read(self) -> CameraFrame | None:
        """The next frame, or None."""
        frame = self._camera.read()
        if frame is not None:
            self.heard_s = time.monotonic()
        return frame

    def close(self) -> None:
        """Let the device go."""
        self._camera.close()


def why_no_set(cameras: Sequence[HeardCamera], maximum_skew_s: float, now_s: float) -> str:
    """In words, with what to do about it."""
    silent = [
        camera.name
        for camera in cameras
        if camera.heard_s is None or (not camera.ended and now_s - camera.heard_s > PATIENCE_S)
    ]
    if silent:
        return f"no picture comes from camera {' and '.join(silent)}"
    return (
        f"pictures come from all cameras, but are taken more than {MS_PER_S * maximum_skew_s:.0f} ms apart: do the cameras keep "
        "the rate that the bench file asks for? (nodal cameras look)"
    )
