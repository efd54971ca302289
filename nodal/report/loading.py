"""From a recording to a `BenchRun`; pictures are fetched one frame set at a time."""

from collections.abc import Iterable
from pathlib import Path

from messaging import topics
from messaging.control import ControllerState, Target, TendonCommand, TendonState
from messaging.errors import CodecError, InvalidMessageError
from messaging.frames import CameraCalibration, Frame
from messaging.history import Asked
from messaging.message import Message
from messaging.shape import ShapeEstimate, Truth
from messaging.views import LogLine
from nodal.bench_file import CALIBRATION_ATTACHMENT
from nodal.calibration_file import rig_in
from nodal.errors import CalibrationFileError
from nodal.report.bench_run import Accepted, BenchRun, Line
from nodal.report.traffic import topic_traffic
from recordings import Log
from recordings.errors import UnknownTopicError
from recordings.reader import topic_of

DECODED = (
    topics.SHAPE,
    topics.TRUTH,
    topics.CONTROLLER_STATE,
    topics.TENDON_COMMAND,
    topics.TENDON_STATE,
    topics.TARGET,
    topics.ASKED,
    topics.LOG,
)
"""Topics whose messages a report looks into; of all others, pictures among them, the number is all that counts."""

LOGGED_WITHIN_NS = 1_000_000_000


def load_run(recording: Path | Log) -> BenchRun:
    """Everything but pictures; raises RecordingError when there is no such recording.

    Messages that cannot be read are counted in the run's `traffic`, damaged places are in the log's `damage`.
    """
    log = recording if isinstance(recording, Log) else Log(recording)
    rig, _ = attached_rig(log)
    run = BenchRun(rig=rig, losses=_lost(log))
    for recorded in log.messages():
        heard = topic_traffic(run.traffic, recorded.topic)
        heard.hear(recorded)
        topic = topic_of(recorded.topic)
        if topic is topics.CAMERA:
            run.frames.hear(recorded.topic, recorded.sequence)
        elif topic in DECODED:
            try:
                _sort_in(run, recorded.message, recorded.log_time_ns)
            except (CodecError, InvalidMessageError, UnknownTopicError) as error:
                heard.refuse(str(error))
    return run


def frame_set(log: Log, time_ns: int) -> dict[str, Frame]:
    """Each camera's frame that was captured nearest to this Unix time."""
    frames: dict[str, Frame] = {}
    for recorded in log.messages((topics.CAMERA,), time_ns, time_ns + LOGGED_WITHIN_NS):
        if isinstance(frame := recorded.message, Frame):
            nearest = frames.setdefault(frame.camera, frame)
            if abs(frame.capture_time_ns - time_ns) < abs(nearest.capture_time_ns - time_ns):
                frames[frame.camera] = frame
    return frames


def _sort_in(run: BenchRun, message: Message, log_time_ns: int) -> None:
    match message:
        case ShapeEstimate():
            run.shapes.append(message)
        case Truth():
            run.truths.append(message)
        case ControllerState():
            run.states.append(message)
        case TendonCommand():
            run.commands.append(message)
        case TendonState():
            run.tendons.append(message)
        case Target():
            run.accepted.append(Accepted(time_ns=log_time_ns, target=message))
        case Asked():
            run.asked.append(message)
        case LogLine(wire=wire):
            time_ns = wire.timestamp.ToNanoseconds()
            run.lines.append(
                Line(time_ns=time_ns, level=10 * wire.level, process=wire.name, text=wire.message)
            )


def attached_rig(log: Log) -> tuple[tuple[CameraCalibration, ...], str]:
    """The attached calibration, and what is wrong with it; without one no picture can show where the robot was seen."""
    attached = log.attachments.get(CALIBRATION_ATTACHMENT)
    if attached is None:
        return (), f"no {CALIBRATION_ATTACHMENT} is attached"
    try:
        return rig_in(attached, f"attachment {CALIBRATION_ATTACHMENT}"), ""
    except CalibrationFileError as error:
        return (), str(error)


def _lost(log: Log) -> int:
    """What the recorder counted as lost; a part that was cut off holds no count."""
    return sum(lost_in(log.metadata("SUMMARY").values()).values())


def lost_in(summaries: Iterable[dict[str, str]]) -> dict[str, int]:
    """Publications lost by topic, as recorders' summaries count them."""
    lost: dict[str, int] = {}
    for summary in summaries:
        for key, count in summary.items():
            if key.startswith("lost/"):
                topic = key.removeprefix("lost/")
                lost[topic] = lost.get(topic, 0) + int(count)
    return lost
