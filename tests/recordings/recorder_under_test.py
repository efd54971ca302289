"""A recorder in a process of its own: `python recorder_under_test.py RENDEZVOUS PATH SETTINGS STALL SYNCED`.

While the file STALL exists its disk does nothing: writes and syncs wait. After each sync, SYNCED has a line with the size
that the device keeps from then on.
"""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import msgspec

from messaging.session import open_session
from messaging.settings import ZenohSettings
from recordings.process import run
from recordings.settings import RecorderSettings


def slow_down(stall, synced):
    """Put a disk that can be stalled in the place of the real one."""
    pwrite, fdatasync = os.pwrite, os.fdatasync

    def wait_while_stalled():
        while stall.exists():
            time.sleep(0.01)

    def slow_pwrite(file, data, offset):
        wait_while_stalled()
        return pwrite(file, data, offset)

    def slow_fdatasync(file):
        wait_while_stalled()
        size = os.fstat(file).st_size
        fdatasync(file)
        with synced.open("a") as told:
            told.write(f"{size}\n")

    os.pwrite, os.fdatasync = slow_pwrite, slow_fdatasync


def main(rendezvous, path, settings, stall, synced):
    """Record until SIGTERM; without a path only when asked."""
    slow_down(Path(stall), Path(synced))
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    with open_session(ZenohSettings(rendezvous=rendezvous), "bench", "record") as session:
        run(
            msgspec.json.decode(settings, type=RecorderSettings),
            Path(path) if path else None,
            {"bench.toml": b"name = 'bench'"},
            session,
            stop,
            lambda: None,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
