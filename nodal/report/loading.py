"""From a recording's files to a `BenchRun`; pictures are fetched one frame set at a time."""

from pathlib import Path

from messaging import topics
from messaging.control import ControllerState, Target, TendonCommand
from messaging.frames import CameraCalibration, Frame
from messaging.shape import ShapeEstimate, Truth
from nodal.bench_file import CALIBRATION_ATTACHMENT
from nodal.calibration_file import rig_in
from nodal.errors import ReportError
from nodal.report.bench_run import BenchRun
from recordings import Log
from recordings.reader import Recorded

DECODED = (topics.SHAPE, topics.TRUTH, topics.CONTROLLER_STATE, topics.TENDON_COMMAND, topics.TARGET)

LOGGED_WITHIN_NS = 1_000_000_000


def load_run(recording: Path) -> BenchRun:
    """Everything but pictures, from all parts; raises ReportError, or RecordingError when there is no such recording."""
    log = Log(recording)
    run = BenchRun(rig=_rig(log), losses=_lost(log))
    for recorded in log.messages((*DECODED, topics.CAMERA)):
        _sort_in(run, recorded)
    return run


def frame_set(recording: Path, time_ns: int) -> dict[str, Frame]:
    """Each camera's frame that was captured nearest to this Unix time."""
    frames: dict[str, Frame] = {}
    for recorded in Log(recording).messages((topics.CAMERA,), time_ns, time_ns + LOGGED_WITHIN_NS):
        if isinstance(frame := recorded.message, Frame):
            nearest = frames.setdefault(frame.camera, frame)
            if abs(frame.capture_time_ns - time_ns) < abs(nearest.capture_time_ns - time_ns):
                frames[frame.camera] = frame
    return frames


def _sort_in(run: BenchRun, recorded: Recorded) -> None:
    if recorded.schema == Frame.protobuf.DESCRIPTOR.full_name:
        # a frame's number is all that counts here, so its picture stays undecoded
        run.frames.hear(recorded.topic, recorded.sequence)
        return
    match recorded.message:
        case ShapeEstimate() as shape:
            run.shapes.append(shape)
        case Truth() as truth:
            run.truths.append(truth)
        case ControllerState() as state:
            run.states.append(state)
        case TendonCommand() as command:
            run.commands.append(command)
        case Target() as target:
            run.targets[target.name] = target


def _rig(log: Log) -> tuple[CameraCalibration, ...]:
    if CALIBRATION_ATTACHMENT not in log.attachments:
        raise ReportError(f"{log.path}: no {CALIBRATION_ATTACHMENT} is attached")
    return rig_in(log.attachments[CALIBRATION_ATTACHMENT], f"{log.path}, attachment {CALIBRATION_ATTACHMENT}")


def _lost(log: Log) -> int:
    """What the recorder counted as lost; a part that was cut off holds no count."""
    return sum(
        int(count)
        for summary in log.metadata("SUMMARY").values()
        for key, count in summary.items()
        if key.startswith("lost/")
    )
