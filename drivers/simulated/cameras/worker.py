"""The child process of one simulated camera: what it sees in by a pipe, JPEG frames out on the bus.

It ends when the pipe does, which the kernel sees to even after kill -9 of the parent.
"""

import os
import signal
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection

import cv2

from drivers.simulated.cameras.arrays import Array
from drivers.simulated.cameras.printed_board import REFERENCE_BOARD
from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from drivers.simulated.cameras.subjects import Subject
from messaging.board import BoardSettings
from messaging.frames import CameraCalibration, Frame
from messaging.session import open_session
from messaging.settings import ZenohSettings
from messaging.topics import SIMULATED_CAMERA

READY = "ready"
LATE_NS = 80_000_000


@dataclass(frozen=True, kw_only=True)
class Setup:
    """All that a camera's process has to know; the first thing in its pipe."""

    calibration: CameraCalibration
    section_end_mm: Array
    settings: SimulatedCamerasSettings
    seed: int
    zenoh: ZenohSettings
    bench: str
    board: BoardSettings = REFERENCE_BOARD


@dataclass(frozen=True, kw_only=True)
class Exposure:
    """One picture to be rendered."""

    number: int
    capture_monotonic_ns: int
    subject: Subject
    scene: int = 0
    """Which scene it is of, counted from 0; once two pictures of a later one are out, its number goes back through the pipe."""


def serve(descriptor: int) -> None:
    """Render what comes through this pipe until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to act upon
    cv2.setNumThreads(1)
    with Connection(descriptor) as pipe:
        try:
            setup: Setup = pipe.recv()
            name = setup.calibration.camera
            renderer = Renderer(
                setup.calibration, setup.section_end_mm, setup.settings, setup.seed, setup.board
            )
            with open_session(setup.zenoh, setup.bench, f"simulated-camera-{name}-{os.getpid()}") as session:
                publisher = session.publisher(SIMULATED_CAMERA.named(name))
                pipe.send(READY)
                before = told = 0
                while True:
                    exposure = _next(pipe)
                    jpeg = exposure.subject.picture(renderer)
                    frame = Frame(camera=name, capture_time_ns=exposure.capture_monotonic_ns, jpeg=jpeg)
                    publisher.put(frame, exposure.number)
                    if told < exposure.scene == before:
                        told = exposure.scene
                        pipe.send(told)
                    before = exposure.scene
        except (EOFError, ConnectionError):
            return


def _next(pipe: Connection) -> Exposure:
    """A camera that falls behind for a moment catches up; one that cannot keep up leaves frames out, as a real one does."""
    exposure: Exposure = pipe.recv()
    while pipe.poll() and time.monotonic_ns() - exposure.capture_monotonic_ns > LATE_NS:
        exposure = pipe.recv()
    return exposure
