"""Where stand-in cameras are found: device files in a folder, and the calls on them led away from the kernel."""

import errno
import fcntl
import io
import mmap
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Protocol

import linuxpy.io
import linuxpy.ioctl
import linuxpy.video.device
from linuxpy.util import to_fd
from linuxpy.video import raw

from drivers.cameras.v4l2 import device_files
from drivers.simulated.v4l2.camera import StandInCamera
from drivers.simulated.v4l2.device_files import DeviceFiles


class _Node(Protocol):
    """What stands behind an open device file."""

    def ioctl(self, file: int, request: int, argument: Any) -> None: ...

    def closed(self, file: int) -> None: ...


@contextmanager
def plugged_in(*cameras: StandInCamera) -> Iterator[Path]:
    """Plug the cameras in, for this process; gives the folder that takes the place of /dev."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        for camera in cameras:
            camera.files = DeviceFiles(folder, camera.description)
            camera.plug_in()
            stack.callback(camera.pull_out)
        calls = _Calls(cameras)
        for target, name, substitute in (
            (linuxpy.io.IO, "open", calls.open),
            (linuxpy.ioctl, "fcntl", SimpleNamespace(ioctl=calls.ioctl)),
            (linuxpy.video.device, "mem_map", calls.mem_map),
            (device_files, "DEVICES", folder),
        ):
            stack.enter_context(_in_place_of(target, name, substitute))
        yield folder


@contextmanager
def _in_place_of(target: Any, name: str, substitute: Any) -> Iterator[None]:
    """Until the block is left."""
    own = vars(target)[name]
    setattr(target, name, substitute)
    try:
        yield
    finally:
        setattr(target, name, own)


class _Calls:
    """open, ioctl and mmap on device files; the kernel's own for every other file."""

    def __init__(self, cameras: tuple[StandInCamera, ...]) -> None:
        self._cameras = cameras
        self._nodes: dict[int, _Node] = {}
        self._open: Callable[..., io.FileIO] = linuxpy.io.IO.open
        self._mem_map: Callable[..., mmap.mmap] = linuxpy.video.device.mem_map

    def open(self, path: Path, *how: Any, **else_how: Any) -> io.FileIO:
        resolved = Path(path).resolve()
        for camera in self._cameras:
            nodes = camera.files.nodes if camera.files else ()
            if resolved in nodes:
                if not camera.is_permitted:
                    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
                file = camera.opened()
                self._nodes[file] = camera if resolved == nodes[0] else _MetadataNode(camera)
                return _OpenFile(file, self._closed)
        return self._open(path, *how, **else_how)

    def ioctl(self, file: Any, request: int, *arguments: Any) -> None:
        node = self._nodes.get(to_fd(file))
        if node is None:
            fcntl.ioctl(file, request, *arguments)
        else:
            node.ioctl(to_fd(file), request, *arguments)

    def mem_map(self, file: Any, length: int, offset: int) -> mmap.mmap:
        node = self._nodes.get(to_fd(file))
        if isinstance(node, StandInCamera):
            return node.buffers.map(length, offset)
        return self._mem_map(file, length, offset)

    def _closed(self, file: int) -> None:
        self._nodes.pop(file).closed(file)


class _OpenFile(io.FileIO):
    def __init__(self, file: int, closed: Callable[[int], None]) -> None:
        super().__init__(file, "rb+")
        self._tell = closed

    def close(self) -> None:
        if not self.closed:
            self._tell(self.fileno())
        super().close()


class _MetadataNode:
    """The second device file of a UVC camera, which gives no pictures."""

    def __init__(self, camera: StandInCamera) -> None:
        self._camera = camera

    def ioctl(self, file: int, request: int, argument: Any) -> None:
        if request != raw.IOC.QUERYCAP:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
        self._camera.ioctl(file, request, argument)
        argument.device_caps = raw.Capability.META_CAPTURE | raw.Capability.STREAMING

    def closed(self, file: int) -> None:
        self._camera.closed(file)
