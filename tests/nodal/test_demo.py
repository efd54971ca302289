"""The demo, really run: what it leaves, what it survives, and that nothing stays behind."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from functools import partial
from pathlib import Path

import pytest

from messaging.control import State
from messaging.session import open_session
from nodal.bench_file import load_bench
from nodal.demo.telemetry import Telemetry
from recordings.file_reader import FileReader
from recordings.parts import parts

PROCESSES = ("rendezvous", "record", "simulate", "sense", "control")
IN_THE_LOOP = ("simulate", "sense", "control")
SUMMARY = {
    "frame_sets": None,
    "estimates": None,
    "estimate_rate_hz": None,
    "flagged": None,
    "node_error_mm": {"mean", "p95", "max"},
    "tip_error_mm": {"mean", "p95", "max"},
    "tracking_error_mm": {"rms", "steady"},
    "open_loop_error_mm": {"rms"},
    "capture_to_command_ms": {"p50", "p99"},
    "control_lateness_ms": {"p50", "p99"},
    "recording": None,
    "recording_losses": None,
}
PICTURES = (
    "estimate-cameras.png",
    "estimate-space.png",
    "estimate-along.png",
    "path.png",
    "error.png",
)


MARK = "NODAL_TEST_RUN"
"""A variable that every descendant of a demo inherits, the cameras' processes too."""


def start_demo(bench, folder, *words):
    return subprocess.Popen(
        [sys.executable, "-m", "nodal", "demo", "--config", str(bench), "--out", str(folder), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, MARK: str(folder)},
    )


def descendants(folder):
    """Pid and command line of every process of this demo."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            if f"{MARK}={folder}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                found[int(entry.name)] = (entry / "cmdline").read_text(encoding="utf-8").split("\0")
        except (OSError, ValueError):
            continue
    return found


def processes_of(folder):
    """The pids of the processes that the demo started, by subcommand."""
    return {
        words[words.index("nodal") + 1]: pid
        for pid, words in descendants(folder).items()
        if "--end-with" in words
    }


def wait_until(met, what, within_s=60.0, demo=None):
    deadline = time.monotonic() + within_s
    while not met():
        assert time.monotonic() < deadline, f"{what} did not come within {within_s} s"
        assert demo is None or demo.poll() is None, demo.communicate()[1]
        time.sleep(0.05)


def is_back(folder, name, killed):
    return processes_of(folder).get(name, killed) != killed


def finished(recording):
    return "SUMMARY" in FileReader(recording).metadata()


def assert_nothing_is_left(folder):
    assert descendants(folder) == {}
    assert not (folder / "servos").is_symlink()


@pytest.fixture(scope="module")
def demo(light_bench, tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo") / "run"
    process = start_demo(light_bench, folder, "--duration", "12", "--json")
    out, err = process.communicate(timeout=150)
    assert process.returncode == 0, err
    return folder, out, err


def test_the_summary_is_one_json_object(demo):
    folder, out, _ = demo
    summary = json.loads(out)

    assert summary.keys() == SUMMARY.keys()
    for key, inner in SUMMARY.items():
        assert inner is None or summary[key].keys() == inner
    assert summary == json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_the_loop_is_closed(demo):
    summary = json.loads(demo[1])

    assert summary["frame_sets"] > 0
    assert summary["estimates"] > summary["frame_sets"] / 2
    assert summary["node_error_mm"]["mean"] < 0.5
    assert summary["tracking_error_mm"]["rms"] < summary["open_loop_error_mm"]["rms"] / 2
    assert summary["capture_to_command_ms"]["p50"] > 0


def test_the_recording_is_finished_and_says_what_ran(demo):
    folder, out, _ = demo
    recording = folder / json.loads(out)["recording"]

    assert finished(recording)
    assert (
        FileReader(recording).attachments()["calibration.json"] == (folder / "calibration.json").read_bytes()
    )
    assert tomllib.loads(FileReader(recording).attachments()["bench.toml"].decode())["name"] == "simulated"
    topics = {message.topic for message in FileReader(recording).messages()}
    assert {"camera/left", "camera/right", "shape", "truth", "target", "tendon/command", "log"} <= topics


def test_pictures_are_left(demo):
    for picture in PICTURES:
        assert (demo[0] / picture).read_bytes().startswith(b"\x89PNG")


def test_people_are_told_on_stderr(demo):
    assert "tendons are relaxed" in demo[2]
    assert "Traceback" not in demo[2]


def test_a_finished_demo_leaves_nothing_running(demo):
    assert_nothing_is_left(demo[0])


def test_killed_processes_come_back_and_a_closed_terminal_ends_it_well(light_bench, tmp_path):
    folder = tmp_path / "run"
    demo = start_demo(light_bench, folder, "--duration", "600")
    try:
        wait_until(lambda: len(processes_of(folder)) == len(PROCESSES), "all processes", demo=demo)
        settings = load_bench(folder / "bench.toml").settings
        with open_session(settings.zenoh, settings.name, "test") as session:
            telemetry = Telemetry(session)

            def tracking():
                telemetry.take()
                return telemetry.state is State.TRACKING and telemetry.shape is not None

            wait_until(tracking, "tracking", demo=demo)
            for name in PROCESSES:
                killed = processes_of(folder)[name]
                os.kill(killed, signal.SIGKILL)
                wait_until(partial(is_back, folder, name, killed), f"{name} again", demo=demo)
                if name in IN_THE_LOOP:
                    wait_until(lambda: not tracking(), f"an end of tracking without {name}", demo=demo)
                wait_until(tracking, f"tracking after {name} was killed", demo=demo)

        demo.send_signal(signal.SIGHUP)
        _, err = demo.communicate(timeout=90)
    finally:
        demo.kill()

    assert demo.returncode == 0, err
    assert_nothing_is_left(folder)
    recordings = parts(folder / "demo.mcap")
    assert [finished(part) for part in recordings] == [False, True]
    assert json.loads((folder / "summary.json").read_text(encoding="utf-8"))["estimates"] > 0


def test_ctrl_c_before_anything_runs_leaves_nothing(light_bench, tmp_path):
    folder = tmp_path / "run"
    demo = start_demo(light_bench, folder)
    wait_until(lambda: "rendezvous" in processes_of(folder), "the first process", demo=demo)

    demo.send_signal(signal.SIGINT)
    _, err = demo.communicate(timeout=60)

    assert demo.returncode == 130, err
    assert "Traceback" not in err
    assert_nothing_is_left(folder)


def test_a_killed_demo_takes_its_processes_along(light_bench, tmp_path):
    folder = tmp_path / "run"
    demo = start_demo(light_bench, folder)
    wait_until(lambda: len(processes_of(folder)) == len(PROCESSES), "all processes", demo=demo)
    wait_until((folder / "servos").is_symlink, "the serial link", demo=demo)

    demo.kill()
    demo.communicate()

    wait_until(lambda: not descendants(folder), "the end of all processes")
    assert_nothing_is_left(folder)
    assert finished(folder / "demo.mcap")
