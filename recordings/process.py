"""The recorder: everything that the table of topics wants logged goes into an MCAP file, and so does what was lost.

Beside the publications a recording holds the attached files and two metadata records: VERSIONS at its beginning and, at
its end, SUMMARY with `messages/<topic>`, `lost/<topic>` and `duration_s`; a recorder that was killed leaves no SUMMARY.
"""

import logging
import platform
import threading
import time
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path

from messaging.errors import CodecError
from messaging.session import Session, Subscription
from messaging.topics import TOPICS, Topic
from recordings.parts import next_part
from recordings.recorder import Recorder, Summary
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

logger = logging.getLogger(__name__)

IDLE_S = 0.005
SWEEP = 16
PACKAGES = ("nodal", "eclipse-zenoh", "mcap", "protobuf", "foxglove-schemas-protobuf")


def run(
    settings: RecorderSettings,
    path: Path,
    attachments: Mapping[str, bytes],
    session: Session,
    stop: threading.Event,
    healthy: Callable[[], None],
) -> Summary:
    """Record the bench until `stop` is set, then finish the file; a recording that was cut off goes on in its next part.

    Raises RecordingInUseError, RecordingExistsError, UnwritableError or, at any time, DiskFullError: what was written
    until then stays readable.
    """
    now_ns = _steady_unix_clock()
    with RecordingWriter(next_part(path), settings) as recording:
        for name, data in attachments.items():
            recording.attach(name, data, now_ns())
        recording.describe("VERSIONS", _versions())
        recorder = Recorder(recording, now_ns())
        rings = [(topic, session.every(topic, settings.ring_depth)) for topic in TOPICS if topic.logged]
        logger.info("recording to %s", recording.path)
        settle_at_ns = 0
        while not stop.is_set():
            heard = _sweep(rings, recorder, now_ns)
            if now_ns() >= settle_at_ns:
                recorder.settle(now_ns())
                settle_at_ns = now_ns() + int(settings.flush_period_s * 1e9)
            healthy()
            if not heard:
                # not stop.wait: a signal handler that sets an Event its own thread waits on can lock up
                time.sleep(IDLE_S)
        for _ in range(settings.ring_depth // SWEEP):
            _sweep(rings, recorder, now_ns)
        recorder.end(now_ns())
    return recorder.summary(now_ns())


def _sweep(rings: list[tuple[Topic, Subscription]], recorder: Recorder, now_ns: Callable[[], int]) -> bool:
    """Log what waits in the rings; True when there was something."""
    heard = False
    for topic, ring in rings:
        # bounded, so that one busy topic can keep neither the others nor `stop` waiting
        for _ in range(SWEEP):
            try:
                received = ring.take()
            except CodecError as error:
                recorder.refuse(error)
                continue
            if received is None:
                break
            recorder.hear(topic, received, now_ns())
            heard = True
    return heard


def _steady_unix_clock() -> Callable[[], int]:
    """Unix time that a step of the host's clock cannot turn back, so that a recording stays in order."""
    offset_ns = time.time_ns() - time.monotonic_ns()
    return lambda: time.monotonic_ns() + offset_ns


def _versions() -> dict[str, str]:
    return {"python": platform.python_version(), **{package: version(package) for package in PACKAGES}}
