"""What stands in for the bench: the simulated bench at first, then only what hardware leaves to a PC.

A lab's cameras code their JPEG themselves and its robot moves by itself. Here both would take the cores that are to be
measured. So the simulated bench runs until the loop is closed and the robot at rest; from then on its last pictures are
played again and again, with capture times of their own, and only the servos' answers on the serial device are computed.
"""

import contextlib
import multiprocessing
import os
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np

from drivers.simulated.cameras.process import CameraProcess, camera_processes
from drivers.simulated.cameras.schedule import NS_PER_S, CaptureSchedule, Pose, PoseHistory
from drivers.simulated.cameras.subjects import RobotInHolder
from drivers.simulated.cameras.worker import Exposure, Setup
from drivers.simulated.mechanism import Mechanism
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.stage_place import StagePlace
from messaging.frames import Frame
from messaging.session import Session, open_session
from messaging.topics import SIMULATED_CAMERA
from nodal.bench_file import Bench, load_bench

KEPT = 60
"""Pictures of each camera that are played in a round: two seconds."""

FIRST = 90
"""SCHED_FIFO priority of what stands for hardware."""


@contextmanager
def standing_in(bench_file: Path) -> Iterator[tuple[multiprocessing.process.BaseProcess, Event]]:
    """The process that stands in, and the event on which it begins to play."""
    context = multiprocessing.get_context("spawn")
    playing, stop = context.Event(), context.Event()
    process = context.Process(target=stand_in, args=(bench_file, playing, stop))
    process.start()
    try:
        yield process, playing
    finally:
        stop.set()
        process.join()


def stand_in(bench_file: Path, playing: Event, stop: Event) -> None:
    """Simulate until `playing`, then play until `stop`."""
    sys.setswitchinterval(0.0002)  # the servos' thread answers the bus while this one publishes pictures
    bench = load_bench(bench_file)
    settings = bench.settings
    if settings.simulation is None:
        raise ValueError(f"{bench_file} has no [simulation]")
    with (
        open_session(settings.zenoh, settings.name, "simulation") as session,
        EmulatedServos(settings.simulation.servos) as servos,
    ):
        simulation = settings.simulation
        schedule = CaptureSchedule(
            len(bench.rig), simulation.cameras.sensor, time.monotonic_ns(), simulation.seed
        )
        photographs = _Photographs(bench, session, schedule)
        mechanism = Mechanism(
            SimulatedRobot(simulation.robot), servos, simulation.drive, StagePlace(simulation.servos.link)
        )
        period_s = 1 / simulation.step_rate_hz
        due_s = time.monotonic()
        with camera_processes(_setups(bench), stop.is_set) as renderers:
            while not (playing.is_set() or stop.is_set()):
                pose = mechanism.step(period_s).shape.centreline_mm
                photographs.take(renderers, Pose(time.monotonic_ns(), pose))
                due_s = max(due_s + period_s, time.monotonic())
                time.sleep(max(0.0, due_s - time.monotonic()))
        _be_hardware()
        player = _Player(photographs, session, schedule)
        no_load = np.zeros(len(simulation.servos.ids))
        while not stop.is_set():
            servos.step(period_s, no_load)
            due_s = max(due_s + period_s, time.monotonic())
            player.play_until(due_s)


def _be_hardware() -> None:
    """Hardware waits for no core: every thread of this process goes before all others, where that is allowed."""
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(int(thread.name), os.SCHED_FIFO, os.sched_param(FIRST))


def _setups(bench: Bench) -> list[Setup]:
    simulation = bench.settings.simulation
    assert simulation is not None
    return [
        Setup(
            calibration=known,
            section_end_mm=np.cumsum([section.length_mm for section in simulation.robot.sections]),
            settings=simulation.cameras,
            seed=simulation.seed + number,
            zenoh=bench.settings.zenoh,
            bench=bench.settings.name,
        )
        for number, known in enumerate(bench.rig)
    ]


class _Photographs:
    """Has the robot photographed, and keeps the last pictures of each camera."""

    def __init__(self, bench: Bench, session: Session, schedule: CaptureSchedule) -> None:
        simulation = bench.settings.simulation
        assert simulation is not None
        self.kept = {known.camera: deque[bytes](maxlen=KEPT) for known in bench.rig}
        self.half_exposure_ns = int(simulation.cameras.sensor.exposure_s / 2 * NS_PER_S)
        self._heard = {name: session.every(SIMULATED_CAMERA.named(name), KEPT) for name in self.kept}
        self._schedule = schedule
        self._history = PoseHistory(keep_s=0.25)
        self._number = 0

    def take(self, renderers: list[CameraProcess], pose: Pose) -> None:
        """The robot is here now: take the pictures whose exposure is over, and hear of those that were rendered."""
        self._history.add(pose)
        captures_ns = self._schedule.captures_ns(self._number)
        if max(captures_ns) + self.half_exposure_ns <= pose.time_ns:
            for renderer, capture_ns in zip(renderers, captures_ns, strict=True):
                renderer.take(
                    Exposure(
                        number=self._number,
                        capture_monotonic_ns=capture_ns,
                        subject=RobotInHolder(
                            opened_mm=self._history.at(capture_ns - self.half_exposure_ns),
                            closed_mm=self._history.at(capture_ns + self.half_exposure_ns),
                        ),
                    )
                )
            self._number = self._schedule.first_after(pose.time_ns)
        for name, subscription in self._heard.items():
            while (received := subscription.take()) is not None:
                self.kept[name].append(Frame.from_bytes(received.payload).jpeg)


class _Player:
    """Hands the kept pictures out, each as soon as its exposure would be over."""

    def __init__(self, photographs: _Photographs, session: Session, schedule: CaptureSchedule) -> None:
        self._kept = photographs.kept
        self._half_exposure_ns = photographs.half_exposure_ns
        self._voices = {name: session.publisher(SIMULATED_CAMERA.named(name)) for name in self._kept}
        self._schedule = schedule
        self._waiting: list[tuple[int, str, int]] = []

    def play_until(self, end_s: float) -> None:
        """Play until this time on the monotonic clock."""
        while True:
            if not self._waiting:
                number = self._schedule.first_after(time.monotonic_ns())
                captures_ns = self._schedule.captures_ns(number)
                self._waiting = sorted(
                    (capture_ns, name, number)
                    for name, capture_ns in zip(self._voices, captures_ns, strict=True)
                )
            capture_ns, name, number = self._waiting[0]
            due_s = (capture_ns + self._half_exposure_ns) / NS_PER_S
            time.sleep(max(0.0, min(due_s, end_s) - time.monotonic()))
            if due_s >= end_s:
                return
            del self._waiting[0]
            jpeg = self._kept[name][number % len(self._kept[name])]
            self._voices[name].put(Frame(camera=name, capture_time_ns=capture_ns, jpeg=jpeg), number)
