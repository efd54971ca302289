"""The driver of a simulated camera: the simulated bench hands its frames over on the bus."""

import logging
from typing import cast

from drivers.cameras.camera import CameraFrame
from messaging.errors import CodecError
from messaging.frames import Frame
from messaging.session import Session
from messaging.topics import SIMULATED_CAMERA

logger = logging.getLogger(__name__)


class SimulatedCamera:
    """Frames of one simulated camera. It may come and go; while it is away there is nothing to read."""

    def __init__(self, name: str, session: Session) -> None:
        self._name = name
        self._frames = session.newest(SIMULATED_CAMERA.named(name))

    @property
    def name(self) -> str:
        """Its name on the bench."""
        return self._name

    def read(self) -> CameraFrame | None:
        """The newest frame that was not read yet, or None; what is not a frame is logged and left out."""
        try:
            taken = self._frames.take()
        except CodecError as error:
            logger.warning("camera %s: %s", self._name, error)
            return None
        if taken is None:
            return None
        frame, received = cast("Frame", taken[0]), taken[1]
        return CameraFrame(
            name=self._name,
            jpeg=frame.jpeg,
            capture_monotonic_ns=frame.capture_time_ns,
            number=received.sequence,
        )

    def close(self) -> None:
        """Nothing is held but a subscription, which ends with its session."""
