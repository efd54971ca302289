"""Has the simulated cameras take their pictures when they are due, and says the truth about each frame set."""

import logging
import time
from collections.abc import Sequence

import numpy as np

from drivers.simulated.cameras.process import CameraProcess
from drivers.simulated.cameras.schedule import NS_PER_S, CaptureSchedule, Pose, PoseHistory
from drivers.simulated.cameras.worker import Exposure
from drivers.simulated.scenes import Scenes
from drivers.simulated.settings import SimulationSettings
from messaging import topics
from messaging.session import Session
from messaging.shape import Truth

logger = logging.getLogger(__name__)

HISTORY_S = 0.25
LATE_S = 0.1


class Photographer:
    """Pictures of whatever the scene is; the truth is said only of a robot that is seen."""

    def __init__(
        self,
        settings: SimulationSettings,
        cameras: Sequence[CameraProcess],
        scenes: Scenes,
        session: Session,
        start_ns: int,
    ) -> None:
        self._cameras = cameras
        self._scenes = scenes
        self._schedule = CaptureSchedule(len(cameras), settings.cameras.sensor, start_ns, settings.seed)
        self._half_exposure_ns = int(settings.cameras.sensor.exposure_s / 2 * NS_PER_S)
        self._history = PoseHistory(HISTORY_S)
        self._number = self._schedule.first_after(start_ns + self._half_exposure_ns)
        self._truth = session.publisher(topics.TRUTH)
        self._length_mm = sum(section.length_mm for section in settings.robot.sections)
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
            if self._scenes.robot_is_seen:
                self._say_truth(sum(captures_ns) // len(captures_ns))
            self._number += 1

    def _take(self, camera: CameraProcess, capture_ns: int) -> None:
        camera.check()
        exposure = Exposure(
            number=self._number,
            capture_monotonic_ns=capture_ns,
            subject=self._scenes.subject(
                self._pose_at(capture_ns - self._half_exposure_ns),
                self._pose_at(capture_ns + self._half_exposure_ns),
            ),
            scene=self._scenes.number,
        )
        if not camera.take(exposure):
            logger.warning(
                "simulated camera %s does not keep up: frame %d is lost", camera.name, self._number
            )

    def _pose_at(self, time_ns: int) -> Pose:
        return Pose(time_ns, self._history.at(time_ns))

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
