"""From a recording to a film, one scene after another."""

import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from messaging import topics
from messaging.errors import NodalError
from messaging.frames import CameraCalibration
from nodal.bench_file import CALIBRATION_ATTACHMENT
from nodal.calibration_file import rig_in
from nodal.errors import CommandError
from nodal.exports.output import new_file
from nodal.exports.video.encoder import Encoder
from nodal.exports.video.scenes import Scene, Scenes
from nodal.exports.video.stage import Stage
from nodal.log.spans import Span
from recordings.log import Log
from recordings.reader import Recorded

NARROWEST_PX, WIDEST_PX = 320, 7680
PROGRESS_S = 5.0


def write_film(log: Log, names: Sequence[str], span: Span, width_px: int, path: Path) -> list[str]:
    """These cameras (all when none is named) in real time; returns a line that says what was written.

    Raises CommandError, ExportError, CalibrationFileError, RecordingError, and NodalError without PyAV.
    """
    if not NARROWEST_PX <= width_px <= WIDEST_PX:
        raise CommandError(f"--width {width_px}: a film is {NARROWEST_PX} to {WIDEST_PX} px wide")
    stage = Stage(_cameras(log, names), width_px, span.beginning_ns)
    progress = _Progress(span)
    with new_file(path) as draft, Encoder(draft, stage.width_px, stage.height_px) as film:
        for scene in scenes_of(log, span):
            if any(panel.camera.name in scene.frames for panel in stage.panels):
                film.add(stage.drawn(scene), scene.time_ns)
                progress.tell(scene.time_ns)
        if not film.pictures:
            raise CommandError(f"{log.path}: no pictures were recorded then")
    size = f"{stage.width_px}x{stage.height_px} px"
    return [f"{path}: {film.pictures} pictures, {film.duration_s:.1f} s, {size}"]


def scenes_of(log: Log, span: Span) -> Iterator[Scene]:
    """The scenes of a stretch, with the targets that were accepted before it; what cannot be read is warned of once."""
    scenes = Scenes()
    unreadable: Counter[str] = Counter()
    if span.start_ns > span.beginning_ns:
        for recorded in log.messages((topics.TARGET,), None, span.start_ns):
            list(_heard(scenes, recorded, unreadable))
    shown = (topics.CAMERA, topics.SHAPE, topics.CONTROLLER_STATE, topics.TARGET)
    for recorded in log.messages(shown, span.start_ns, span.end_ns):
        yield from _heard(scenes, recorded, unreadable)
    yield from scenes.rest()
    for problem, count in unreadable.items():
        print(f"nodal: warning: {count} left out: {problem}", file=sys.stderr)


def _heard(scenes: Scenes, recorded: Recorded, unreadable: Counter[str]) -> Iterator[Scene]:
    try:
        message = recorded.message
    except NodalError as error:
        unreadable[f"{recorded.topic}: {error}"] += 1
        return
    yield from scenes.hear(recorded.sequence, recorded.log_time_ns, message)


def _cameras(log: Log, names: Sequence[str]) -> list[CameraCalibration]:
    if CALIBRATION_ATTACHMENT not in log.attachments:
        raise CommandError(
            f"{log.path}: no {CALIBRATION_ATTACHMENT} is attached, so nothing can be drawn into the pictures; "
            "--to jpeg writes them as they are"
        )
    rig = rig_in(log.attachments[CALIBRATION_ATTACHMENT], f"{log.path}, attachment {CALIBRATION_ATTACHMENT}")
    known = {camera.camera: camera for camera in rig}
    if strangers := [name for name in names if name not in known]:
        raise CommandError(f"--camera {strangers[0]}: the recording's cameras are {', '.join(known)}")
    return [known[name] for name in names] or list(rig)


class _Progress:
    """Says now and then on stderr how far a long film has come."""

    def __init__(self, span: Span) -> None:
        self._span = span
        self._due_s = time.monotonic() + PROGRESS_S

    def tell(self, time_ns: int) -> None:
        if time.monotonic() >= self._due_s:
            self._due_s = time.monotonic() + PROGRESS_S
            done_s, whole_s = ((end - self._span.start_ns) / 1e9 for end in (time_ns, self._span.end_ns))
            print(f"nodal: film: {done_s:.0f} of {whole_s:.0f} s", file=sys.stderr)
