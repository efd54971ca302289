"""From settings to running cameras."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager

from drivers.cameras.camera import Camera
from drivers.cameras.settings import CameraSettings
from drivers.cameras.simulated import SimulatedCamera
from messaging.session import Session


@contextmanager
def open_cameras(settings: Mapping[str, CameraSettings], session: Session) -> Iterator[list[Camera]]:
    """The bench's cameras in the order of their settings, closed again when the block is left; raises CameraError."""
    with ExitStack() as opened:
        cameras: list[Camera] = []
        for name in settings:
            camera = SimulatedCamera(name, session)
            opened.callback(camera.close)
            cameras.append(camera)
        yield cameras
