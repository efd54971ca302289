"""The parent's side of the cameras' child processes."""

import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Self

from drivers.simulated.cameras.errors import SimulatedCameraError
from drivers.simulated.cameras.worker import Exposure, Setup

_START_S = 60.0
_END_S = 5.0
_POLL_S = 0.05


class CameraProcess:
    """One camera's child process. The child is fed through a socket, and ends when this end of it closes."""

    def __init__(self, setup: Setup) -> None:
        """Start it; `is_ready` says when it is."""
        self.name = setup.calibration.camera
        ours, theirs = socket.socketpair()
        with theirs:
            self._child = subprocess.Popen(  # noqa: S603  our own interpreter, our own module
                [sys.executable, "-m", "drivers.simulated.cameras", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        self._pipe = Connection(ours.detach())
        self._pipe.send(setup)
        self._ready = False
        self._scene = 0

    @property
    def scene(self) -> int:
        """The latest scene of which pictures are out; raises SimulatedCameraError when it has ended."""
        self.check()
        try:
            while self._pipe.poll():
                self._scene = int(self._pipe.recv())
        except (EOFError, ConnectionError) as error:
            raise SimulatedCameraError(f"simulated camera {self.name}: its process has gone") from error
        return self._scene

    @property
    def is_ready(self) -> bool:
        """Whether it renders; raises SimulatedCameraError when it has ended."""
        self.check()
        if not self._ready and self._pipe.poll():
            self._ready = bool(self._pipe.recv())
        return self._ready

    def check(self) -> None:
        """Raises SimulatedCameraError when it has ended."""
        status = self._child.poll()
        if status is not None:
            raise SimulatedCameraError(
                f"simulated camera {self.name}: its process ended with status {status}"
            )

    def take(self, exposure: Exposure) -> bool:
        """Have a picture taken, unless so many are waiting that there is no room; never waits."""
        _, room, _ = select.select([], [self._pipe], [], 0)
        if room:
            try:
                self._pipe.send(exposure)
            except ConnectionError as error:
                raise SimulatedCameraError(f"simulated camera {self.name}: its process has gone") from error
        return bool(room)

    def close(self) -> None:
        """End it."""
        self._pipe.close()
        try:
            self._child.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()

    def __enter__(self) -> Self:
        """Running."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End it."""
        self.close()


@contextmanager
def camera_processes(
    setups: Sequence[Setup], is_stopping: Callable[[], bool]
) -> Iterator[list[CameraProcess]]:
    """Processes of all cameras, ready to render unless `is_stopping` first; raises SimulatedCameraError."""
    with ExitStack() as running:
        cameras = [running.enter_context(CameraProcess(setup)) for setup in setups]
        deadline_s = time.monotonic() + _START_S
        while not all(camera.is_ready for camera in cameras) and not is_stopping():
            if time.monotonic() > deadline_s:
                late = ", ".join(camera.name for camera in cameras if not camera.is_ready)
                raise SimulatedCameraError(f"simulated camera {late}: not ready within {_START_S:g} s")
            time.sleep(_POLL_S)
        yield cameras
