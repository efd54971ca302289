"""The bytes of one file by their place: bounded reads, few system calls, and no more than what the file held when opened."""

import os
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from mcap.writer import MCAP0_MAGIC

from recordings.errors import UnreadableError

MAGIC = MCAP0_MAGIC
WINDOW = 16 * 1024
"""Bytes that are read at once for the sake of small records which follow one another."""


class Source:
    """A file that is open for reading; used in a `with` statement. Every method raises UnreadableError."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open_to_read(path)
        self.size = os.fstat(self._file.fileno()).st_size
        self._window, self._window_at = b"", 0

    def read(self, offset: int, length: int) -> bytes:
        """Bytes from this place on; fewer where the file ends."""
        length = min(length, self.size - offset)
        if length <= 0:
            return b""
        if length > WINDOW:
            return self._fetch(offset, length)
        begin = offset - self._window_at
        if begin < 0 or begin + length > len(self._window):
            self._window, self._window_at, begin = self._fetch(offset, WINDOW), offset, 0
        return self._window[begin : begin + length]

    def __enter__(self) -> Self:
        """The open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._file.close()

    def _fetch(self, offset: int, length: int) -> bytes:
        try:
            self._file.seek(offset)
            return self._file.read(min(length, self.size - offset))
        except OSError as error:
            raise _unreadable(self.path, error) from error


def open_to_read(path: Path) -> IO[bytes]:
    """The file, unbuffered; raises UnreadableError."""
    try:
        return path.open("rb", buffering=0)
    except OSError as error:
        raise _unreadable(path, error) from error


def finished(path: Path) -> bool:
    """True when the recorder ended the file itself; raises UnreadableError."""
    with Source(path) as source:
        return ends_with_magic(source)


def ends_with_magic(source: Source) -> bool:
    """True when the file was ended as MCAP files are."""
    return source.size > len(MAGIC) and source.read(source.size - len(MAGIC), len(MAGIC)) == MAGIC


def _unreadable(path: Path, error: OSError) -> UnreadableError:
    return UnreadableError(path, f"it cannot be read: {error.strerror}")
