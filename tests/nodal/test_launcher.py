"""The demo's processes: started, heard, restarted, stopped, and gone when the demo is."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from nodal.bench_file import load_bench
from nodal.demo.folder import make_demo_folder, processes_of
from nodal.errors import BenchFileError, DemoError, ProcessError
from nodal.processes import child as children
from nodal.processes.child import Child
from nodal.processes.launcher import Stopped


@pytest.fixture
def folder(tmp_path):
    return make_demo_folder(load_bench("simulated"), tmp_path / "demo")[0]


@pytest.fixture
def child(folder):
    child = Child("rendezvous", ("--config", str(folder.bench_file)), folder.logs)
    yield child
    child.stop()
    child.close()


def tend_until(child, met):
    deadline = time.monotonic() + 20
    while not met():
        assert time.monotonic() < deadline, child.last_words()
        child.tend()
        time.sleep(0.02)


def running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_a_child_says_that_it_is_ready_and_ends_when_told(child):
    child.start()
    tend_until(child, lambda: child.ready)

    assert os.getsid(child.pid) == child.pid
    assert child.stop()
    assert child.pid is None


def test_a_child_that_was_killed_comes_back(child):
    child.start()
    tend_until(child, lambda: child.ready)
    first = child.pid

    os.kill(first, signal.SIGKILL)
    tend_until(child, lambda: child.restarts == 1 and child.ready)

    assert child.pid != first


def test_a_child_that_hangs_is_started_anew(child, monkeypatch):
    child.start()
    tend_until(child, lambda: child.ready)
    monkeypatch.setattr(children, "SILENCE_S", 0.2)

    os.kill(child.pid, signal.SIGSTOP)
    tend_until(child, lambda: child.restarts == 1)
    monkeypatch.undo()
    tend_until(child, lambda: child.ready)


def test_a_child_that_keeps_dying_is_an_error_with_its_last_words(folder, child, monkeypatch):
    monkeypatch.setattr(children, "RESTART_AFTER_S", 0.0)
    monkeypatch.setattr(children, "RESTARTS_ALLOWED", 1)
    port = int(load_bench(folder.bench_file).settings.zenoh.rendezvous.rpartition(":")[2])
    with socket.socket() as occupant:
        occupant.bind(("127.0.0.1", port))
        occupant.listen()
        child.start()
        with pytest.raises(ProcessError) as raised:
            tend_until(child, lambda: False)

    assert "rendezvous ended 2 times" in str(raised.value)
    assert "last with status 2" in str(raised.value)
    assert f"127.0.0.1:{port} cannot be opened: the address is already in use" in str(raised.value)
    assert str(child.log_file) in str(raised.value)


def test_children_end_when_the_demo_is_killed(folder):
    program = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from nodal.processes.child import Child\n"
        f"child = Child('rendezvous', ('--config', {str(folder.bench_file)!r}), Path({str(folder.logs)!r}))\n"
        "child.start()\n"
        "while not child.ready:\n"
        "    child.tend()\n"
        "    time.sleep(0.02)\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    demo = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    pid = int(demo.stdout.readline())
    assert running(pid)

    demo.kill()
    demo.communicate()

    deadline = time.monotonic() + 20
    while running(pid):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_demo_gets_a_bench_of_its_own(folder):
    own, shipped = load_bench(folder.bench_file), load_bench("simulated")

    assert own.settings.servos.port == str(folder.path / "servos") == own.settings.simulation.servos.link
    assert own.settings.zenoh.rendezvous != shipped.settings.zenoh.rendezvous
    assert own.rig == shipped.rig
    assert own.settings.controller == shipped.settings.controller


def test_a_bench_that_is_not_simulated_is_refused(tmp_path):
    bench = load_bench("simulated")
    text = bench.text().partition("\n[simulation]")[0]
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")

    with pytest.raises(DemoError, match=r"it has no \[simulation\]"):
        make_demo_folder(load_bench(tmp_path / "bench.toml"), tmp_path / "demo")


def test_a_recording_is_never_overwritten(folder):
    folder.recording.touch()

    with pytest.raises(DemoError, match="a demo was recorded here already"):
        make_demo_folder(load_bench("simulated"), folder.path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()

    with pytest.raises(BenchFileError, match=r"--out = .*file/demo: cannot be made"):
        make_demo_folder(load_bench("simulated"), tmp_path / "file" / "demo")


def test_stop_ends_a_wait_at_once(folder):

    stop = threading.Event()
    stop.set()
    with processes_of(folder, stop) as launcher, pytest.raises(Stopped):
        launcher.wait_until(lambda: False, "nothing", 60)


def test_what_does_not_come_in_time_is_named(folder):

    with (
        processes_of(folder, threading.Event()) as launcher,
        pytest.raises(ProcessError, match="the moon did not come"),
    ):
        launcher.wait_until(lambda: False, "the moon", 0.1)
