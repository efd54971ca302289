"""Which recordings a path means: a recording's file with its parts, or a folder of recordings."""

import re
from pathlib import Path

from nodal.errors import CommandError
from recordings import Log

LATER_PART = re.compile(r"(.+)\.part[1-9]\d*(\.mcap)")


def logs_in(path: Path) -> list[Log]:
    """The recording at this path, or all of those in this folder; raises CommandError when there is none, UnreadableError."""
    if not path.is_dir():
        return [Log(path)]
    files = sorted(path.glob("*.mcap"))
    firsts = {LATER_PART.sub(r"\1\2", file.name) for file in files}
    if not firsts:
        raise CommandError(f"{path}: there is no recording (*.mcap) in this folder")
    return [Log(path / name) for name in sorted(firsts)]


def one_log(path: Path) -> Log:
    """The same, when it is one; raises CommandError."""
    logs = logs_in(path)
    if len(logs) > 1:
        names = ", ".join(log.path.name for log in logs)
        raise CommandError(f"{path}: this folder holds {len(logs)} recordings ({names}); name one of them")
    return logs[0]
