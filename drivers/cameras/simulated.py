"""The driver of a simulated camera: the simulated bench hands its frames over on the bus."""

import logging

from drivers.cameras.camera import CameraFrame
from messaging.errors import CodecError
from messaging.frames import Frame
from messaging.session import Session
from messaging.topics import SIMULATED_CAMERA

logger = logging.getLogger(__name__)

WAITING_AT_MOST = 2


class SimulatedCamera:
    """Frames of one simulated camera. It may come and go; while it is away there is nothing to read."""

    def __init__(self, name: str, session: Session) -> None:
        self._name = name
        self._frames = session.every(SIMULATED_CAMERA.named(name), WAITING_AT_MOST)

    @property
    def name(self) -> str:
        """Its name on the bench."""
        return self._name

    @property
    def ended(self) -> bool:
        """Never."""
        return False

    def read(self) -> CameraFrame | None:
        """The next frame that was not read yet, or None; what is not a frame is logged and left out."""
        try:
            received = self._frames.take()
            frame = None if received is None else Frame.from_bytes(received.payload)
        except CodecError as error:
            logger.warning("camera %s: %s", self._name, error)
            return None
        if received is None or frame is None:
            return None
        return CameraFrame(
            name=self._name,
            jpeg=frame.jpeg,
            capture_monotonic_ns=frame.capture_time_ns,
            number=received.sequence,
        )

    def close(self) -> None:
        """Nothing is held but a subscription, which ends with its session."""
