"""What a recording carries as files: attachments, and the cameras' pictures as they came."""

from collections import Counter
from pathlib import Path

from messaging import topics
from messaging.errors import NodalError
from messaging.frames import Frame
from messaging.topics import Topic
from nodal.errors import CommandError
from nodal.exports.output import new_folder
from nodal.log.spans import Span
from recordings.log import Log


def write_attachments(log: Log, path: Path) -> list[str]:
    """A folder with the attached files: bench file, calibration, backgrounds; returns lines that say what was written."""
    attached = log.attachments
    if not attached:
        raise CommandError(f"{log.path}: nothing is attached to the recording")
    with new_folder(path) as folder:
        for name, data in attached.items():
            if Path(name).name != name:
                raise CommandError(f"{log.path}: an attachment is named {name!r}, which is not a file's name")
            (folder / name).write_bytes(data)
    return [f"{path / name}: {len(data)} bytes" for name, data in attached.items()]


def write_pictures(log: Log, cameras: list[Topic], span: Span, path: Path) -> list[str]:
    """A folder a camera; pictures are named by their capture's Unix time in ns, and their bytes are the camera's own."""
    counts: Counter[str] = Counter()
    with new_folder(path) as folder:
        for recorded in log.messages(cameras, span.start_ns, span.end_ns):
            try:
                frame = recorded.message
            except NodalError:
                counts[f"{recorded.topic}, unreadable"] += 1
                continue
            if isinstance(frame, Frame):
                camera = folder / recorded.topic.rpartition("/")[2]
                camera.mkdir(exist_ok=True)
                (camera / f"{frame.capture_time_ns}.jpg").write_bytes(frame.jpeg)
                counts[recorded.topic] += 1
        if not counts:
            raise CommandError(
                f"{log.path}: it holds no pictures of {', '.join(c.key for c in cameras)} then"
            )
    return [f"{path}: {count} pictures of {key}" for key, count in sorted(counts.items())]


def camera_topics(names: list[str]) -> list[Topic]:
    """The topics of these cameras; of all of them when none is named."""
    return [topics.CAMERA.named(name) for name in names] or [topics.CAMERA]
