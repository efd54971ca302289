"""What every process of a bench has in common: its session, its signals, its log, and its signs of life."""

import ctypes
import logging
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from messaging import topics
from messaging.session import Session, open_rendezvous, open_session
from messaging.views import LogLine
from nodal.bench_settings import BenchSettings
from nodal.notify import Health

PR_SET_PDEATHSIG = 1
ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


@dataclass(frozen=True, kw_only=True)
class Process:
    """What a room's `run` is handed beside its settings."""

    session: Session
    stop: threading.Event
    healthy: Health


@contextmanager
def running(settings: BenchSettings, name: str, end_with: int | None) -> Iterator[Process]:
    """This process as `name` on the bench's bus, until SIGTERM, SIGINT or SIGHUP set `stop`; raises EndpointError."""
    stop = stop_on_signals()
    if end_with is not None:
        _end_with(end_with, stop)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)-7s %(name)s: %(message)s")
    healthy = Health()
    opened = (
        open_rendezvous(settings.zenoh, settings.name)
        if name == "rendezvous"
        else open_session(settings.zenoh, settings.name, name)
    )
    with opened as session:
        published = _PublishedLog(session, name)
        logging.getLogger().addHandler(published)
        try:
            yield Process(session=session, stop=stop, healthy=healthy)
        finally:
            logging.getLogger().removeHandler(published)
            healthy.stopping()


def stop_on_signals() -> threading.Event:
    """An event that SIGTERM, SIGINT and SIGHUP set, instead of ending the process where it stands.

    A thread of its own sets it: a handler that interrupts `stop.wait()` would wait for a lock that its own thread holds.
    """
    stop = threading.Event()
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.set_wakeup_fd(wake)
    for number in ENDING:
        signal.signal(number, lambda *_: None)

    def wait_for_signal() -> None:
        os.read(woken, 1)
        stop.set()

    threading.Thread(target=wait_for_signal, name="signals", daemon=True).start()
    return stop


def _end_with(parent: int, stop: threading.Event) -> None:
    """Have the kernel send SIGTERM when the parent dies, even by kill -9 (prctl(2), PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        stop.set()


class _PublishedLog(logging.Handler):
    """Log lines on the bench's bus, so that they stand in the recording beside what they speak of."""

    def __init__(self, session: Session, process: str) -> None:
        super().__init__(level=logging.INFO)
        self._publisher = session.publisher(topics.LOG)
        self._process = process

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one line; never waits."""
        line = LogLine.of(
            time_ns=time.time_ns(), level=record.levelno, process=self._process, text=record.getMessage()
        )
        self._publisher.put(line)
