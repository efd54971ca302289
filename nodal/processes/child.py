"""One process of the bench, started by another and listened to as systemd would."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from nodal.errors import ProcessError

RESTART_AFTER_S = 1.0
RESTARTS_ALLOWED = 5
RESTART_WINDOW_S = 60.0
SILENCE_S = 20.0
STOP_WITHIN_S = 10.0
TAIL_LINES = 12


class Child:
    """`nodal NAME WORDS` in a session of its own; what it prints goes to a file."""

    def __init__(self, name: str, words: Sequence[str], log_folder: Path) -> None:
        self.name = name
        self.log_file = log_folder / f"{name}.log"
        self.ready = False
        self.restarts = 0
        # -P: a folder named `sensing` where the demo was started must not stand in for the package
        self._words = [sys.executable, "-P", "-m", "nodal", name, *words]
        self._words += ["--end-with", str(os.getpid())]
        self._starts_s: list[float] = []
        self._heard_s = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._line = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        self._line.bind("")
        self._line.setblocking(False)

    @property
    def pid(self) -> int | None:
        """The process id while it runs."""
        return self._process.pid if self._process and self._process.returncode is None else None

    def start(self) -> None:
        """Start it; it is ready when it says so."""
        self.ready = False
        self._heard_s = time.monotonic()
        self._starts_s.append(self._heard_s)
        environment = {
            **os.environ,
            "NOTIFY_SOCKET": "@" + self._line.getsockname()[1:].decode(),
            "WATCHDOG_USEC": str(int(SILENCE_S * 1e6)),
        }
        with self.log_file.open("ab") as log:
            self._process = subprocess.Popen(  # noqa: S603  our own interpreter and our own words
                self._words,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=environment,
                start_new_session=True,
            )

    def tend(self) -> None:
        """Hear its signs of life; start it again when it died. Raises ProcessError when it keeps dying."""
        self._listen()
        if self._process is None:
            return
        status = self._process.poll()
        now_s = time.monotonic()
        if status is None:
            if now_s - self._heard_s > SILENCE_S:
                self._process.kill()
            return
        recent = [start_s for start_s in self._starts_s if now_s - start_s < RESTART_WINDOW_S]
        if len(recent) > RESTARTS_ALLOWED:
            raise ProcessError(
                f"{self.name} ended {len(recent)} times within {RESTART_WINDOW_S:g} s, last with status {status}; "
                f"{self.last_words()}"
            )
        if now_s - self._starts_s[-1] >= RESTART_AFTER_S:
            self.restarts += 1
            self.start()

    def stop(self) -> bool:
        """End it, kindly first; returns whether it ended by itself in time."""
        if self._process is None:
            return True
        self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(STOP_WITHIN_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return False
        return True

    def close(self) -> None:
        """Let its line go."""
        self._line.close()

    def last_words(self) -> str:
        """The end of what it printed, and where the rest is."""
        try:
            lines = self.log_file.read_text(encoding="utf-8", errors="replace").splitlines()[-TAIL_LINES:]
        except OSError:
            lines = []
        said = "".join(f"\n  | {line}" for line in lines) or " nothing"
        return f"its last words ({self.log_file}):{said}"

    def _listen(self) -> None:
        while True:
            try:
                words = self._line.recv(256)
            except BlockingIOError:
                return
            self._heard_s = time.monotonic()
            self.ready = self.ready or b"READY=1" in words
