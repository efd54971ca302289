"""The sensing process: read frame sets, estimate, publish."""

import logging
import time
from collections.abc import Callable, Iterable, Mapping
from threading import Event

import cv2

from drivers.cameras import (
    CameraSettings,
    CameraSilentError,
    FrameSet,
    FrameSetPairing,
    PairingReport,
    SilenceWatch,
    open_cameras,
)
from messaging import topics
from messaging.control import Reply, TendonState
from messaging.errors import NodalError
from messaging.frames import CameraCalibration, Frame
from messaging.history import Asked, Memory
from messaging.session import Newest, Query, Session
from messaging.settings import RobotSettings
from messaging.shape import NodalPoints
from messaging.views import CameraPoseView, CameraView, CentrelineView, NodalPointsView
from sensing.method import bench_method
from sensing.sensor import Sensor
from sensing.settings import SensingSettings

logger = logging.getLogger(__name__)

POLL_S = 0.002
RIG_PERIOD_S = 1.0
MEMORY_PERIOD_NS = 1_000_000_000
SILENCE_S = 2.0


def run(
    settings: SensingSettings,
    robot: RobotSettings,
    calibrations: tuple[CameraCalibration, ...],
    backgrounds: Mapping[str, bytes],
    cameras: Mapping[str, CameraSettings],
    session: Session,
    stop: Event,
    healthy: Callable[[], None],
) -> None:
    """Sense until `stop` is set, or every camera has ended, as files do. `backgrounds` are coded pictures of the scene without the robot, by camera.

    A bad frame becomes a refusal that says why; a camera that falls silent is named in the log and waited for.
    """
    cv2.setNumThreads(1)
    method = bench_method(settings, robot, calibrations, backgrounds)
    sensor = Sensor(method, settings.points, robot.length_mm, settings.stage_age_limit_s)
    speaker = _Speaker(session, calibrations)
    stage_reports = session.newest(topics.TENDON_STATE)
    questions = session.answers(topics.SENSING_NODES)
    pairing = FrameSetPairing(tuple(cameras), settings.maximum_skew_s)
    report = PairingReport(pairing, time.monotonic())
    silence = SilenceWatch(cameras, SILENCE_S, time.monotonic())
    with open_cameras(cameras, session) as sources:
        while not (stop.is_set() or all(source.ended for source in sources)):
            while (question := questions.take()) is not None:
                _rename(sensor, speaker, question)
            frames = [frame for source in sources if (frame := source.read()) is not None]
            silence = _silence_told(silence, cameras, [frame.name for frame in frames])
            frame_sets = [frame_set for frame in frames if (frame_set := pairing.feed(frame)) is not None]
            for frame_set in frame_sets:
                speaker.say_frames(frame_set)
                report.add(frame_set)
            report.tell(time.monotonic())
            if frame_sets:
                _hear(sensor, stage_reports)
                # what has piled up is published for the log, but only the newest set is worth an estimate
                speaker.say_estimate(sensor, frame_sets[-1])
            else:
                # half the cost of waiting for `stop`, which is looked at next anyway
                time.sleep(POLL_S)
            speaker.say_rig()
            healthy()
    if not stop.is_set():
        logger.info("every camera has come to its end")


class _Speaker:
    """Everything that sensing says. Frame sets are numbered here."""

    def __init__(self, session: Session, calibrations: tuple[CameraCalibration, ...]) -> None:
        self._frames = {
            known.camera: session.publisher(topics.CAMERA.named(known.camera)) for known in calibrations
        }
        self._shape = session.publisher(topics.SHAPE)
        self._centreline = session.publisher(topics.CENTRELINE)
        self._nodal_points = session.publisher(topics.NODAL_POINTS)
        self._rig = [
            (session.publisher(topic.named(known.camera)), view, known)
            for known in calibrations
            for topic, view in ((topics.CAMERA_CALIBRATION, CameraView), (topics.CAMERA_POSE, CameraPoseView))
        ]
        self._rig_due_s = 0.0
        self._memory = session.publisher(topics.SENSING_MEMORY)
        self._memory_due_ns = 0
        self._asked = session.publisher(topics.ASKED)
        self._sequence = -1
        # the log's clock is Unix time; ages are measured on the monotonic clock that stamps the captures
        self._unix_from_monotonic_ns = time.time_ns() - time.monotonic_ns()

    def say_frames(self, frame_set: FrameSet) -> None:
        self._sequence += 1
        for frame in frame_set.frames:
            capture_time_ns = frame.capture_monotonic_ns + self._unix_from_monotonic_ns
            message = Frame(camera=frame.name, capture_time_ns=capture_time_ns, jpeg=frame.jpeg)
            self._frames[frame.name].put(message, self._sequence)

    def say_estimate(self, sensor: Sensor, frame_set: FrameSet) -> None:
        captured_ns = frame_set.capture_monotonic_ns
        estimate = sensor.estimate(
            {frame.name: frame.jpeg for frame in frame_set.frames},
            self._sequence,
            captured_ns + self._unix_from_monotonic_ns,
            lambda: time.monotonic_ns() - captured_ns,
        )
        number = self._shape.put(estimate)
        for reason in sensor.lost.values():
            logger.warning("frame set %d without a camera: %s", estimate.sequence, reason)
        if estimate.refusal:
            logger.warning("no shape in frame set %d: %s", estimate.sequence, estimate.refusal)
        else:
            self._centreline.put(CentrelineView.of(estimate))
            self._nodal_points.put(NodalPointsView.of(estimate))
        if estimate.capture_time_ns >= self._memory_due_ns:
            self._memory_due_ns = estimate.capture_time_ns + MEMORY_PERIOD_NS
            self._memory.put(
                Memory(
                    time_ns=estimate.capture_time_ns,
                    content=sensor.memory.to_bytes(),
                    publication=number,
                )
            )

    def say_asked(self, request: bytes, reply: Reply) -> None:
        self._asked.put(Asked.of(topics.SENSING_NODES.key, request, reply, time.time_ns()))

    def say_rig(self) -> None:
        if time.monotonic() >= self._rig_due_s:
            self._rig_due_s = time.monotonic() + RIG_PERIOD_S
            for publisher, view, known in self._rig:
                publisher.put(view.of(known, time.time_ns()))


def _hear(sensor: Sensor, stage_reports: Newest) -> None:
    """Hand on where the stage is; what is not a report is logged and left out.

    One report for each frame set is enough: frames are older than the newest report, and the stage moves evenly between.
    """
    try:
        if (taken := stage_reports.take()) is not None and isinstance(taken[0], TendonState):
            sensor.heard(taken[0])
    except NodalError as error:
        logger.warning("%s: %s", topics.TENDON_STATE.key, error)


def _silence_told(silence: SilenceWatch, cameras: Iterable[str], heard: Iterable[str]) -> SilenceWatch:
    """Note who was heard; silent cameras are named in the log, again each time the silence has lasted that long."""
    now_s = time.monotonic()
    for name in heard:
        silence.heard(name, now_s)
    try:
        silence.check(now_s)
    except CameraSilentError as error:
        logger.warning("%s", error)
        return SilenceWatch(cameras, SILENCE_S, now_s)
    return silence


def _rename(sensor: Sensor, speaker: _Speaker, question: Query) -> None:
    try:
        points = question.request()
        if isinstance(points, NodalPoints):
            sensor.name_points(points)
        reply = Reply(accepted=True, state="", reason="")
    except NodalError as error:
        reply = Reply(accepted=False, state="", reason=str(error))
    speaker.say_asked(question.payload, reply)
    question.reply(reply)
