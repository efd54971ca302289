import contextlib
import os
import resource
import threading
import time

import pytest

from messaging.session import open_rendezvous, open_session
from messaging.topics import CAMERA, TENDON_COMMAND

LOUD_HZ, FRAME_EVERY = 100, 3
JPEG_SIZED = bytes(range(256)) * 1200


class Payload:
    """Bytes that stand for a message: the recorder does not look into them."""

    def __init__(self, content):
        self._content = content

    def to_bytes(self):
        return self._content


class Talker:
    """Says numbered commands at 100 Hz and frames at 33 Hz from a thread, on a schedule that waits for nobody."""

    def __init__(self, session):
        self.commands, self.frames = (
            session.publisher(TENDON_COMMAND),
            session.publisher(CAMERA.named("left")),
        )
        self.said = {"tendon/command": 0, "camera/left": 0}
        self.longest_put_s = 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._talk)
        self._thread.start()

    def stop(self):
        self._stop.set()
        self._thread.join()

    def _talk(self):
        start_s = time.monotonic()
        while not self._stop.is_set():
            before_s = time.monotonic()
            number = self.said["tendon/command"]
            self.commands.put(Payload(b"%d" % number))
            self.said["tendon/command"] += 1
            if number % FRAME_EVERY == 0:
                self.frames.put(Payload(JPEG_SIZED))
                self.said["camera/left"] += 1
            self.longest_put_s = max(self.longest_put_s, time.monotonic() - before_s)
            self._stop.wait(max(0.0, start_s + (number + 1) / LOUD_HZ - time.monotonic()))


@pytest.fixture
def as_message():
    return Payload


@pytest.fixture
def bus(zenoh_settings):
    """A rendezvous and a process that publishes."""
    with (
        open_rendezvous(zenoh_settings, "bench"),
        open_session(zenoh_settings, "bench", "sensing") as session,
    ):
        yield session


@pytest.fixture
def talker(bus):
    """Somebody who goes on talking whatever happens to the recorder."""
    talker = Talker(bus)
    yield talker
    talker.stop()


@pytest.fixture
def small_disk():
    """A limit on the size of files, which the kernel enforces while the context lasts: writes fail as on a full disk."""

    @contextlib.contextmanager
    def limit(size_bytes):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    return limit


@pytest.fixture
def read_only_folder(tmp_path):
    """A folder that this process may not write to, even when the tests run as root."""
    folder = tmp_path / "read-only"
    folder.mkdir(mode=0o555)
    if os.geteuid() != 0:
        yield folder
        return
    os.seteuid(65534)
    try:
        yield folder
    finally:
        os.seteuid(0)
