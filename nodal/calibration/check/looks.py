"""Looks at the bench, spread over a recording or taken now: pictures, and what sensing made of them."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from drivers.cameras import Camera
from messaging import topics
from messaging.control import TendonState
from messaging.session import Session
from messaging.shape import ShapeEstimate
from nodal.bench_file import Bench
from nodal.calibrate.looking import taken
from nodal.errors import CalibrationError
from nodal.replay.frame_sets import FrameSetRecord, never_estimated, pictured
from recordings.log import Log
from sensing.method import bench_method
from sensing.sensor import Sensor


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """One frame set: coded pictures by camera, and the estimate of it; Unix ns."""

    time_ns: int
    jpegs: Mapping[str, bytes]
    estimate: ShapeEstimate


def recorded_looks(log: Log, bench: Bench, count: int) -> Iterator[Look]:
    """At most so many looks, evenly over a recording, oldest first; sets that were never estimated are estimated now.

    Raises CalibrationError for a recording without frame sets of the bench's cameras.
    """
    cameras = [camera.camera for camera in bench.rig]
    records = [FrameSetRecord.of(recorded) for recorded in log.messages((topics.SHAPE,))]
    records = records or never_estimated(log, cameras)
    if not records:
        raise CalibrationError(f"{log.path}: no frame sets of the cameras {', '.join(cameras)} are in it")
    stride = max(len(records) / count, 1.0)
    chosen = [records[int(stride * number)] for number in range(min(count, len(records)))]
    sensor = _sensor(bench)
    found = False
    for one in chosen:
        for record, jpegs in pictured(log, [one], cameras):
            if jpegs is None:
                continue
            found = True
            estimate = record.estimate or _estimated(sensor, jpegs, record.sequence, record.capture_time_ns)
            yield Look(time_ns=record.capture_time_ns, jpegs=jpegs, estimate=estimate)
    if not found:
        raise CalibrationError(f"{log.path}: it holds estimates but none of their pictures")


def live_looks(cameras: Sequence[Camera], session: Session, bench: Bench, count: int) -> Iterator[Look]:
    """So many frame sets as they come; raises CameraSilentError, CalibrationError."""
    sensor, states = _sensor(bench), session.newest(topics.TENDON_STATE)

    def hear() -> None:
        if (received := states.take()) is not None and isinstance(received[0], TendonState):
            sensor.heard(received[0])

    for number in range(count):
        (jpegs,) = taken(cameras, bench.settings.sensing.maximum_skew_s, 1, time.monotonic_ns(), hear)
        now_ns = time.time_ns()
        yield Look(time_ns=now_ns, jpegs=jpegs, estimate=_estimated(sensor, jpegs, number, now_ns))


def _sensor(bench: Bench) -> Sensor:
    settings, robot = bench.settings.sensing, bench.settings.robot
    method = bench_method(settings, robot, bench.rig, bench.backgrounds)
    return Sensor(method, settings.points, robot.length_mm, settings.stage_age_limit_s)


def _estimated(sensor: Sensor, jpegs: Mapping[str, bytes], sequence: int, time_ns: int) -> ShapeEstimate:
    return sensor.estimate(jpegs, sequence, time_ns, lambda: 0)
