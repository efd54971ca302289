"""The files of one recording: a recorder that was killed carries on in a second part beside the first.

    circle.mcap, circle.part2.mcap, circle.part3.mcap ...

Every part stands for itself, with its own attachments; all but the last were cut off.
"""

import itertools
import time
from collections.abc import Iterator
from pathlib import Path

from recordings.errors import RecordingExistsError, RecordingInUseError
from recordings.output import in_use
from recordings.records import finished


def new_path(folder: Path, time_ns: int) -> Path:
    """A name for a recording that starts at this Unix time, in UTC: `2026-05-02T13-04-05Z.mcap`."""
    return folder / time.strftime("%Y-%m-%dT%H-%M-%SZ.mcap", time.gmtime(time_ns // 10**9))


def parts(path: Path) -> list[Path]:
    """The files that there are of this recording, in order."""
    return list(itertools.takewhile(Path.exists, _names(path)))


def next_part(path: Path) -> Path:
    """Where a recorder may go on; raises RecordingInUseError, or RecordingExistsError when the recording is finished."""
    existing = parts(path)
    for part in existing:
        if in_use(part):
            raise RecordingInUseError(part, "another recorder is writing it")
        if finished(part):
            raise RecordingExistsError(part, "it is finished, and recordings are never overwritten")
    return next(itertools.islice(_names(path), len(existing), None))


def _names(path: Path) -> Iterator[Path]:
    yield path
    for number in itertools.count(2):
        yield path.with_name(f"{path.stem}.part{number}{path.suffix}")
