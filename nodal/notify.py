"""Signs of life for whoever started this process: systemd, or the demo's launcher, which listens in the same way."""

import contextlib
import os
import socket
import time
from collections.abc import Mapping

PINGS_PER_WATCHDOG = 4


class Health:
    """Called once start-up is complete and after each healthy cycle: READY=1 first, then rate-limited WATCHDOG=1.

    Follows sd_notify(3): NOTIFY_SOCKET says where to, WATCHDOG_USEC how often. Without NOTIFY_SOCKET it does nothing.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._interval_s = int(environment.get("WATCHDOG_USEC", "0")) / 1e6 / PINGS_PER_WATCHDOG
        self._ready = False
        self._next_s = 0.0

    def __call__(self) -> None:
        """One more healthy cycle; never waits, never fails."""
        if not self._address:
            return
        if not self._ready:
            self._ready = True
            self._say(b"READY=1")
        if self._interval_s and (now_s := time.monotonic()) >= self._next_s:
            self._next_s = now_s + self._interval_s
            self._say(b"WATCHDOG=1")

    def stopping(self) -> None:
        """Say that the process is ending on purpose."""
        if self._address:
            self._say(b"STOPPING=1")

    def _say(self, word: bytes) -> None:
        # a listener that is gone or busy must not end a healthy process; the next ping tells it the same
        with (
            contextlib.suppress(OSError),
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as line,
        ):
            line.setblocking(False)
            line.sendto(word, self._address)
