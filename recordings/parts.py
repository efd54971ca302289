"""The files of one recording: it goes on in a new part when it grows too long, or when its recorder was killed.

    circle.mcap, circle.part2.mcap, circle.part3.mcap ...

Every part stands for itself, with its own attachments. One that was finished because it had grown too long names the next
in its SUMMARY, as `goes_on_in`; one without a SUMMARY was cut off.
"""

import re
import time
from pathlib import Path

from recordings.errors import DamagedRecordingError, RecordingExistsError, RecordingInUseError
from recordings.file_reader import FileReader
from recordings.output import in_use
from recordings.source import finished

GOES_ON_IN = "goes_on_in"


def new_path(folder: Path, time_ns: int, purpose: str = "") -> Path:
    """A free name for a recording that starts at this Unix time, in UTC: `2026-05-02T13-04-05Z.mcap`, `...Z-fault.mcap`."""
    stem = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime(time_ns // 10**9)) + (purpose and f"-{purpose}")
    path, number = folder / f"{stem}.mcap", 1
    while path.exists():
        number += 1
        path = folder / f"{stem}-{number}.mcap"
    return path


def part_path(path: Path, number: int) -> Path:
    """The file of a recording's part; the first is number 1."""
    return path if number == 1 else path.with_name(f"{path.stem}.part{number}{path.suffix}")


def parts(path: Path) -> list[Path]:
    """The files that there are of this recording, in order; a missing part hides none of those after it."""
    return [part_path(path, number) for number in _numbers(path)]


def absent_parts(path: Path) -> list[Path]:
    """Files of this recording that should stand between those that there are."""
    numbers = _numbers(path)
    return [part_path(path, number) for number in range(1, max(numbers, default=0)) if number not in numbers]


def next_number(path: Path) -> int:
    """The part in which a recorder may go on.

    Raises RecordingInUseError, or RecordingExistsError when the recording was ended on purpose.
    """
    numbers = _numbers(path)
    for part in parts(path):
        if in_use(part):
            raise RecordingInUseError(part, "another recorder is writing it")
    if not numbers:
        return 1
    last = part_path(path, numbers[-1])
    if finished(last) and not _goes_on(last):
        raise RecordingExistsError(last, "it is finished, and recordings are never overwritten")
    return numbers[-1] + 1


def would_be_part(file: Path, path: Path) -> bool:
    """Whether this file would be taken for a later part of the recording at `path`."""
    file, path = file.resolve(), path.resolve()
    return file.parent == path.parent and _later(path).fullmatch(file.name) is not None


def _later(path: Path) -> re.Pattern[str]:
    return re.compile(rf"{re.escape(path.stem)}\.part([1-9]\d*){re.escape(path.suffix)}")


def _numbers(path: Path) -> list[int]:
    later = _later(path)
    names = [file.name for file in path.parent.glob("*")] if path.parent.is_dir() else []
    numbers = [int(match[1]) for name in names if (match := later.fullmatch(name))]
    return [1] * path.exists() + sorted(number for number in numbers if number > 1)


def _goes_on(part: Path) -> bool:
    try:
        return GOES_ON_IN in FileReader(part).metadata().get("SUMMARY", {})
    except DamagedRecordingError:
        return False
