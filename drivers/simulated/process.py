"""The simulated bench's process: servos and robot move on, the cameras' processes get the poses, the truth is said."""

import logging
import sys
import time
from collections import Counter
from collections.abc import Callable
from threading import Event

import numpy as np

from drivers.simulated.cameras.process import CameraProcess, camera_processes
from drivers.simulated.cameras.schedule import NS_PER_S, CaptureSchedule, Pose, PoseHistory
from drivers.simulated.cameras.worker import Exposure, Setup
from drivers.simulated.mechanism import Mechanism
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.settings import SimulationSettings
from drivers.simulated.stage_place import StagePlace
from messaging import topics
from messaging.frames import CameraCalibration
from messaging.session import Session
from messaging.settings import ZenohSettings
from messaging.shape import Truth

logger = logging.getLogger(__name__)

HISTORY_S = 0.25
LATE_S = 0.1


def run(
    settings: SimulationSettings,
    calibrations: tuple[CameraCalibration, ...],
    zenoh: ZenohSettings,
    bench: str,
    session: Session,
    stop: Event,
    healthy: Callable[[], None],
) -> None:
    """Simulate until `stop` is set. The cameras' processes open sessions of their own on the bench named `bench`.

    Raises LinkError, RobotBuildError, SimulatedCameraError.
    """
    robot = SimulatedRobot(settings.robot)
    section_end_mm = np.cumsum([section.length_mm for section in settings.robot.sections])
    setups = [
        Setup(
            calibration=calibration,
            section_end_mm=section_end_mm,
            settings=settings.cameras,
            seed=settings.seed + number,
            zenoh=zenoh,
            bench=bench,
        )
        for number, calibration in enumerate(calibrations)
    ]
    period_ns, place = int(NS_PER_S / settings.step_rate_hz), StagePlace(settings.servos.link)
    sys.setswitchinterval(0.0002)  # the servos' thread answers the bus while this one computes
    with (
        camera_processes(setups, stop.is_set) as cameras,
        EmulatedServos(settings.servos) as servos,
    ):
        mechanism = Mechanism(robot, servos, settings.drive, place)
        due_ns = time.monotonic_ns()
        photographer = _Photographer(settings, cameras, float(section_end_mm[-1]), session, due_ns)
        while not stop.is_set():
            state = mechanism.step(period_ns / NS_PER_S)
            photographer.look(Pose(due_ns, state.shape.centreline_mm))
            healthy()
            due_ns += period_ns
            behind_ns = time.monotonic_ns() - due_ns
            if behind_ns > LATE_S * NS_PER_S:
                due_ns += behind_ns // period_ns * period_ns
                logger.warning(
                    "%.2f s late: that time is left out, the robot stood still", behind_ns / NS_PER_S
                )
            stop.wait(max(0, due_ns - time.monotonic_ns()) / NS_PER_S)
    place.forget()


class _Photographer:
    """Has the cameras take their pictures, and says the truth about each frame set."""

    def __init__(
        self,
        settings: SimulationSettings,
        cameras: list[CameraProcess],
        length_mm: float,
        session: Session,
        start_ns: int,
    ) -> None:
        self._cameras = cameras
        self._schedule = CaptureSchedule(len(cameras), settings.cameras.sensor, start_ns, settings.seed)
        self._half_exposure_ns = int(settings.cameras.sensor.exposure_s / 2 * NS_PER_S)
        self._history = PoseHistory(HISTORY_S)
        self._number = self._schedule.first_after(start_ns + self._half_exposure_ns)
        self._lost: Counter[str] = Counter()
        self._truth = session.publisher(topics.TRUTH)
        self._length_mm = length_mm
        self._unix_from_monotonic_ns = time.time_ns() - time.monotonic_ns()

    def look(self, pose: Pose) -> None:
        """The robot is here now: take every picture whose exposure is over."""
        self._history.add(pose)
        while (
            max(captures_ns := self._schedule.captures_ns(self._number)) + self._half_exposure_ns
            <= pose.time_ns
        ):
            if pose.time_ns - min(captures_ns) > LATE_S * NS_PER_S:
                self._number = self._schedule.first_after(pose.time_ns - int(LATE_S / 2 * NS_PER_S))
                continue
            for camera, capture_ns in zip(self._cameras, captures_ns, strict=True):
                self._take(camera, capture_ns)
            self._say_truth(sum(captures_ns) // len(captures_ns))
            self._number += 1

    def _take(self, camera: CameraProcess, capture_ns: int) -> None:
        camera.check()
        exposure = Exposure(
            number=self._number,
            capture_monotonic_ns=capture_ns,
            opened_mm=self._history.at(capture_ns - self._half_exposure_ns),
            closed_mm=self._history.at(capture_ns + self._half_exposure_ns),
        )
        if not camera.take(exposure):
            logger.warning(
                "simulated camera %s does not keep up: frame %d is lost", camera.name, self._number
            )

    def _say_truth(self, capture_ns: int) -> None:
        centreline_mm = self._history.at(capture_ns)
        self._truth.put(
            Truth(
                capture_time_ns=capture_ns + self._unix_from_monotonic_ns,
                arc_mm=np.linspace(0.0, self._length_mm, len(centreline_mm)),
                centreline_mm=centreline_mm,
                insertion_mm=float(centreline_mm[0, 2]),
            )
        )
