"""The buffers of one camera and the pictures that fill them, as videobuf2 does it."""

import collections
import dataclasses
import errno
import itertools
import mmap
import os
import time
from collections.abc import Iterator

from linuxpy.video import raw

NS_PER_US = 1000
US_PER_S = 1_000_000
START_OF_IMAGE = b"\xff\xd8"
UVC_FLAGS = raw.BufferFlag.TIMESTAMP_MONOTONIC | raw.BufferFlag.TSTAMP_SRC_SOE


@dataclasses.dataclass(frozen=True, kw_only=True)
class Filled:
    """A buffer that waits to be fetched."""

    index: int
    length: int
    flags: int
    timestamp_us: int
    sequence: int


class Buffers:
    """Buffers that a program has asked for. One who reads too slowly loses pictures: their numbers are missing then.

    `readable` is a file descriptor to poll on, `mapped` what programs have mapped; `sent` are the pictures that went out, by
    number, the newest few.
    """

    def __init__(self, pictures: Iterator[bytes]) -> None:
        self.readable = _counting_file()
        self.flags = int(UVC_FLAGS)
        self.streaming = False
        self.mapped: list[mmap.mmap] = []
        self._memory: list[int] = []
        self.sent: collections.OrderedDict[int, bytes] = collections.OrderedDict()
        self._pictures = pictures
        self._exposures = itertools.count(1)
        self._queued: collections.deque[int] = collections.deque()
        self._done: collections.deque[Filled] = collections.deque()
        self._sequence = 0

    @property
    def is_waiting(self) -> bool:
        """Whether a filled buffer waits to be fetched."""
        return bool(self._done)

    def next_picture(self) -> bytes:
        """The next picture with a comment of its own, since no sensor gives the same bytes twice (JPEG, ISO 10918-1 B.2.4.5)."""
        comment = f"exposure {next(self._exposures)}".encode()
        header = START_OF_IMAGE + b"\xff\xfe" + (len(comment) + 2).to_bytes(2, "big") + comment
        return header + next(self._pictures).removeprefix(START_OF_IMAGE)

    def request(self, count: int, length: int) -> None:
        """Give `count` buffers of `length` bytes; none gives them back. What is mapped stays so until it is unmapped."""
        self.stop()
        for memory in self._memory:
            os.close(memory)
        self._memory = [os.memfd_create("buffer") for _ in range(count)]
        for memory in self._memory:
            os.truncate(memory, length)

    def map(self, length: int, offset: int) -> mmap.mmap:
        """A program maps the buffer at this offset."""
        self.mapped.append(mmap.mmap(self._memory[offset // mmap.PAGESIZE], length))
        return self.mapped[-1]

    def renew(self) -> None:
        """Nothing is left of what programs held or waited for."""
        self.request(0, 0)
        os.close(self.readable)
        self.readable = _counting_file()

    def break_off(self) -> None:
        """The camera is gone: whoever polls is woken."""
        self.streaming = False
        os.eventfd_write(self.readable, 1)

    def start(self) -> None:
        """Begin to fill buffers; numbers begin at zero."""
        self._sequence = 0
        self.streaming = True

    def stop(self) -> None:
        """Fill no more, and forget what was not fetched."""
        self.streaming = False
        self._queued.clear()
        while self._done:
            self._done.popleft()
            os.eventfd_read(self.readable)

    def queue(self, index: int) -> None:
        """The program wants this buffer filled."""
        self._queued.append(index)

    def fetch(self) -> Filled:
        """The oldest buffer that is filled; raises EAGAIN when there is none."""
        if not self._done:
            raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        os.eventfd_read(self.readable)
        return self._done.popleft()

    def lose(self, pictures: int) -> None:
        """So many pictures never arrived."""
        self._sequence += pictures

    def fill(self, picture: bytes, flags: int = 0, timestamp_ns: int | None = None) -> None:
        """One picture arrives, now unless another time is given."""
        if not self.streaming:
            return
        sequence, self._sequence = self._sequence, self._sequence + 1
        if not self._queued:
            return
        index = self._queued.popleft()
        length = os.pwrite(self._memory[index], picture, 0)
        stamp_ns = time.monotonic_ns() if timestamp_ns is None else timestamp_ns
        self.sent[sequence] = picture
        if len(self.sent) > 100:
            self.sent.popitem(last=False)
        self._done.append(
            Filled(
                index=index,
                length=length,
                flags=self.flags | flags,
                timestamp_us=stamp_ns // NS_PER_US,
                sequence=sequence,
            )
        )
        os.eventfd_write(self.readable, 1)


def _counting_file() -> int:
    """A file descriptor that can be read as often as it was written."""
    return os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC | os.EFD_SEMAPHORE)
