"""Files that are replaced as a whole or not at all: what calibration found must not be lost to a full disk or a cable that is pulled."""

import os
import shutil
from pathlib import Path


def write_whole(path: Path, data: bytes) -> None:
    """Put `data` in the place of the file's content at once, when all of it is on the disk; until then the old content stays.

    A link stays a link, and the file keeps its mode. Raises OSError.
    """
    file = path.resolve()
    if file.exists() and not file.is_file():
        file.write_bytes(data)  # a pipe or a device has no content to be lost, and must not become a file
        return
    new = file.with_name(file.name + ".new")
    try:
        with new.open("wb") as writing:
            writing.write(data)
            writing.flush()
            os.fsync(writing.fileno())
        if file.exists():
            shutil.copymode(file, new)
        new.replace(file)
    except OSError:
        new.unlink(missing_ok=True)
        raise
