"""When the simulated cameras open their shutters, and where the robot was then. Pure."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from drivers.simulated.cameras.arrays import Array
from drivers.simulated.cameras.settings import SensorSettings

NS_PER_S = 1e9


class CaptureSchedule:
    """Capture times of all cameras: one raster, from which each keeps its own phase, and strays a little."""

    def __init__(self, cameras: int, sensor: SensorSettings, start_ns: int, seed: int) -> None:
        self._cameras = cameras
        self._sensor = sensor
        self._start_ns = start_ns
        self._seed = seed
        phase_s = np.random.default_rng(seed).uniform(-1, 1, cameras) * sensor.phase_s
        # with few cameras chance may leave no phase between them; stretched, they always span the whole range
        spread = float(np.ptp(phase_s))
        self._phase_s = (phase_s - phase_s.min()) / spread * 2 * sensor.phase_s if spread else phase_s

    def captures_ns(self, number: int) -> Sequence[int]:
        """Capture times of every camera's frame of this number, counted from 0."""
        strays = np.random.default_rng((self._seed, number)).standard_normal(self._cameras)
        after_s = number / self._sensor.rate_hz + self._phase_s + self._sensor.jitter_s * strays
        times: list[int] = (self._start_ns + np.rint(after_s * NS_PER_S).astype(np.int64)).tolist()
        return times

    def first_after(self, now_ns: int) -> int:
        """The first number whose captures all lie after a time."""
        number = max(0, int((now_ns - self._start_ns) / NS_PER_S * self._sensor.rate_hz) - 1)
        while min(self.captures_ns(number)) <= now_ns:
            number += 1
        return number


@dataclass(frozen=True)
class Pose:
    """The robot's centreline (N, 3) in the robot frame at a time on CLOCK_MONOTONIC."""

    time_ns: int
    centreline_mm: Array


class PoseHistory:
    """The last poses of the robot; in between it moved evenly."""

    def __init__(self, keep_s: float) -> None:
        self._keep_ns = keep_s * NS_PER_S
        self._poses: deque[Pose] = deque()

    def add(self, pose: Pose) -> None:
        """The newest pose; older ones are forgotten in time."""
        self._poses.append(pose)
        while len(self._poses) > 2 and self._poses[1].time_ns < pose.time_ns - self._keep_ns:
            self._poses.popleft()

    def at(self, time_ns: int) -> Array:
        """The centreline (N, 3) at a time between the oldest and the newest pose; before and after, theirs."""
        if time_ns <= self._poses[0].time_ns:
            return self._poses[0].centreline_mm
        for before, after in pairwise(self._poses):
            if time_ns <= after.time_ns:
                share = (time_ns - before.time_ns) / (after.time_ns - before.time_ns)
                between: Array = (1 - share) * before.centreline_mm + share * after.centreline_mm
                return between
        return self._poses[-1].centreline_mm
