"""The file a recording is written to: created exclusively, locked, and never left with half a record by a full disk."""

import contextlib
import errno
import fcntl
import os
from pathlib import Path
from types import TracebackType
from typing import Self

from recordings.errors import (
    DeletedError,
    DiskFullError,
    RecordingExistsError,
    RecordingInUseError,
    UnwritableError,
)
from recordings.source import open_to_read

NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class Output:
    """A new file that this process alone writes. Each `write` is in the file as a whole, or not at all.

    Raises RecordingInUseError, RecordingExistsError or UnwritableError when it cannot be created.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except FileExistsError as error:
            if in_use(path):
                raise RecordingInUseError(path, "another recorder is writing it") from error
            raise RecordingExistsError(
                path, "it exists already, and recordings are never overwritten"
            ) from error
        except OSError as error:
            raise self._unwritable(error) from error
        fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._end = 0
        self._named = False

    def write(self, data: bytes) -> int:
        """Append; raises DiskFullError or UnwritableError, and then the file ends where it did before."""
        written = 0
        try:
            while written < len(data):
                written += os.pwrite(self._file, memoryview(data)[written:], self._end + written)
        except OSError as error:
            # a device that fails may refuse this too, and half a record is left out when the file is read
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._end)
            raise self._unwritable(error) from error
        self._end += written
        return written

    def tell(self) -> int:
        """Bytes written so far."""
        return self._end

    def sync(self) -> None:
        """Have the device keep what was written, so that a power cut cannot take it.

        Raises UnwritableError, and DeletedError when nobody can find the file any more.
        """
        try:
            if os.fstat(self._file).st_nlink == 0:
                raise DeletedError(
                    self.path, f"it was deleted after {self._end} bytes, while it was being written"
                )
            if not self._named:
                self._sync_folder()
                self._named = True
            os.fdatasync(self._file)
        except OSError as error:
            raise self._unwritable(error) from error

    def close(self) -> None:
        """Let go of the file and its lock; raises UnwritableError when the device has failed meanwhile."""
        try:
            os.close(self._file)
        except OSError as error:
            raise self._unwritable(error) from error

    def __enter__(self) -> Self:
        """The open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    def _sync_folder(self) -> None:
        folder = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def _unwritable(self, error: OSError) -> UnwritableError:
        if error.errno in NO_ROOM:
            written = getattr(self, "_end", 0)
            return DiskFullError(
                self.path,
                f"no room is left ({error.strerror}) after {written} bytes; what was written is readable",
            )
        if isinstance(error, FileNotFoundError):
            return UnwritableError(self.path, f"the folder {self.path.parent} does not exist")
        return UnwritableError(self.path, f"it cannot be written: {error.strerror}")


def free_bytes(path: Path) -> int:
    """Room that is left for this user where the file stands, or would if its folder were made."""
    folder = next(folder for folder in path.absolute().parents if folder.exists())
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize


def make_folder_of(path: Path) -> None:
    """Make the folder of this file if it is missing; raises UnwritableError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnwritableError(path, f"its folder cannot be made: {error.strerror}") from error


def in_use(path: Path) -> bool:
    """True when a recorder holds this file; raises UnreadableError."""
    with open_to_read(path) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False
