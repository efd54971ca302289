"""The emulated bus's serial device: a pty that clients open like any adapter, and the thread that serves it."""

import fcntl
import heapq
import os
import pty
import select
import struct
import threading
import time
import tty
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from drivers.simulated.servos.bus import Answer
from drivers.simulated.servos.errors import LinkError

TERMIOS2 = struct.Struct("=4I B19s 2I")
TCGETS2 = 0x8000542A | TERMIOS2.size << 16
"""ioctl(2): struct termios2 of a terminal, whose last field is the speed at which its client sends."""


class PtySerial:
    """A pty in raw mode, reached through a symbolic link at a path of one's choice.

    This side keeps the client's end open, so that clients come and go as with a real adapter. What a client does not read
    is lost, as on a real line. After kill -9 only a link that leads nowhere is left, which the next `open` replaces.
    """

    def __init__(self, link: str, receive: Callable[[bytes, int], Iterable[Answer]]) -> None:
        """Bytes from clients, and at what speed they came, go to `receive` on this object's thread; `open` begins."""
        self._link = Path(link)
        self._receive = receive
        self._thread: threading.Thread | None = None
        self._ends: tuple[int, int] = (-1, -1)
        self._wake: tuple[int, int] = (-1, -1)

    @property
    def is_serving(self) -> bool:
        """Whether the thread is there to answer."""
        return self._thread is not None and self._thread.is_alive()

    def open(self) -> None:
        """Make the device and place the link; raises LinkError when the path is taken by something else."""
        ours, clients = self._ends = pty.openpty()
        tty.setraw(clients)
        os.set_blocking(ours, False)
        try:
            self._place_link(os.ttyname(clients))
        except LinkError:
            self._close_ends()
            raise
        self._wake = os.pipe()
        self._thread = threading.Thread(target=self._serve, name=f"servos at {self._link}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop serving, and take the link away unless it leads elsewhere by now."""
        if self._thread is None:
            return
        os.close(self._wake[1])
        self._thread.join()
        self._thread = None
        os.close(self._wake[0])
        if self._link.is_symlink() and str(self._link.readlink()) == os.ttyname(self._ends[1]):
            self._link.unlink()
        self._close_ends()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _place_link(self, device: str) -> None:
        if self._link.exists() and not self._link.is_symlink():
            raise LinkError(
                f"{self._link} is taken by something that is not a link to a serial device; choose another"
            )
        fresh = self._link.with_name(f".{self._link.name}.{os.getpid()}")
        try:
            fresh.symlink_to(device)
            fresh.replace(self._link)
        except OSError as error:
            raise LinkError(f"cannot place a link to {device} at {self._link}: {error.strerror}") from error

    def _close_ends(self) -> None:
        for end in self._ends:
            os.close(end)

    def _serve(self) -> None:
        ours, woken = self._ends[0], self._wake[0]
        due: list[tuple[float, int, bytes]] = []
        count = 0
        while True:
            wait_s = max(0.0, due[0][0] - time.monotonic()) if due else None
            ready, _, _ = select.select([ours, woken], [], [], wait_s)
            if woken in ready:
                return
            now_s = time.monotonic()
            if ours in ready:
                for answer in self._receive(os.read(ours, 4096), self._speed()):
                    heapq.heappush(due, (now_s + answer.delay_s, count, answer.data))
                    count += 1
            while due and due[0][0] <= now_s:
                self._send(heapq.heappop(due)[2])

    def _speed(self) -> int:
        speed: int = TERMIOS2.unpack(fcntl.ioctl(self._ends[1], TCGETS2, bytes(TERMIOS2.size)))[-1]
        return speed

    def _send(self, data: bytes) -> None:
        try:
            os.write(self._ends[0], data)
        except BlockingIOError:
            return  # the client has let thousands of bytes lie unread
