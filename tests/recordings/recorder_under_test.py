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

rendezvous, path, settings, stall, synced = sys.argv[1:]
pwrite, fdatasync = os.pwrite, os.fdatasync


def wait_while_stalled():
    while Path(stall).exists():
        time.sleep(0.01)


def slow_pwrite(file, data, offset):
    wait_while_stalled()
    return pwrite(file, data, offset)


def slow_fdatasync(file):
    wait_while_stalled()
    size = os.fstat(file).st_size
    fdatasync(file)
    with Path(synced).open("a") as told:
        told.write(f"{size}\n")


os.pwrite, os.fdatasync = slow_pwrite, slow_fdatasync
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
