"""From settings to running cameras."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager

from drivers.cameras.camera import Camera
from drivers.cameras.files.opening import file_cameras
from drivers.cameras.files.settings import FileCameraSettings
from drivers.cameras.settings import CameraSettings
from drivers.cameras.simulated import SimulatedCamera
from drivers.cameras.v4l2.settings import V4l2CameraSettings
from messaging.session import Session


@contextmanager
def open_cameras(
    settings: Mapping[str, CameraSettings], session: Session, *, paced: bool = True
) -> Iterator[list[Camera]]:
    """The bench's cameras in the order of their settings, closed again when the block is left; raises CameraError.

    Cameras that are files play in real time, as though a bench were there; without `paced` they give every frame as fast as it
    is read.
    """
    of_files = {name: camera for name, camera in settings.items() if isinstance(camera, FileCameraSettings)}
    with ExitStack() as opened:
        cameras: dict[str, Camera] = {camera.name: camera for camera in file_cameras(of_files, paced=paced)}
        for camera in cameras.values():
            opened.callback(camera.close)
        for name, chosen in settings.items():
            if name not in cameras:
                cameras[name] = _device(name, chosen, session)
                opened.callback(cameras[name].close)
        yield [cameras[name] for name in settings]


def _device(name: str, settings: CameraSettings, session: Session) -> Camera:
    """A camera that is no file."""
    if isinstance(settings, V4l2CameraSettings):
        # it imports linuxpy, which benches without webcams do without
        from drivers.cameras.v4l2.camera import V4l2Camera  # noqa: PLC0415

        return V4l2Camera(name, settings)
    return SimulatedCamera(name, session)
