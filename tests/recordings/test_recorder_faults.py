"""Whatever happens to the recorder or to its disk: those who talk do not notice, and what it costs is bounded and told."""

import contextlib
import itertools
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import msgspec
import pytest

from messaging.recorder import RecorderAction, RecorderRequest
from messaging.topics import LOG, RECORDER_DO
from recordings.file_reader import FileReader
from recordings.parts import parts
from recordings.settings import RecorderSettings
from recordings.source import finished

SCRIPT = Path(__file__).with_name("recorder_under_test.py")
SECOND_NS = 1_000_000_000
COMMAND, FRAME = "tendon/command", "camera/left"


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def stall(tmp_path):
    """The disk does nothing while this file exists."""
    return tmp_path / "stall"


@pytest.fixture
def synced(tmp_path):
    """A line for each time the device was told to keep the file."""
    return tmp_path / "synced"


@pytest.fixture
def start(zenoh_settings, bus, path, stall, synced):
    """Start a recorder in a process of its own."""
    with contextlib.ExitStack() as processes:

        def begin(file=path, **chosen):
            settings = RecorderSettings(**{"flush_period_s": 0.1, "least_free_bytes": 0, **chosen})
            words = [zenoh_settings.rendezvous, file, msgspec.json.encode(settings).decode(), stall, synced]
            process = subprocess.Popen([sys.executable, SCRIPT, *map(str, words)])
            processes.callback(process.wait)
            processes.callback(process.kill)
            return process

        yield begin


@pytest.fixture
def ask(bus):
    """Ask the recorder."""

    def say(action, file=""):
        return bus.ask(RECORDER_DO, RecorderRequest(action=RecorderAction(action), file=str(file)), 15.0)

    return say


@pytest.fixture
def mounted(tmp_path):
    """Mount a file system in memory with these options: its folder, or None where only root may."""
    with contextlib.ExitStack() as mounts:

        def mount(options):
            folder = tmp_path / "mounted"
            folder.mkdir()
            command = ["mount", "-t", "tmpfs", "-o", options, "none", str(folder)]
            if (
                shutil.which("mount") is None
                or subprocess.run(command, capture_output=True, check=False).returncode
            ):
                return None
            mounts.callback(subprocess.run, ["umount", "--lazy", str(folder)], check=True)
            return folder

        yield mount


@pytest.fixture
def disk(mounted, small_disk, tmp_path):
    """A disk on which a file can have 8 MB and no more."""
    if (folder := mounted("size=8m")) is not None:
        yield folder
    else:
        with small_disk(8 * 2**20):
            yield tmp_path / "mounted"


def sequences(path, key):
    return [one.sequence for part in parts(path) for one in FileReader(part).messages() if one.topic == key]


def holds_both(path):
    return {COMMAND, FRAME} <= {one.topic for part in parts(path) for one in FileReader(part).messages()}


def lines(path):
    return [one.message.wire.message for part in parts(path) for one in FileReader(part).messages([LOG])]


def end(process):
    process.send_signal(signal.SIGTERM)
    assert process.wait(30) == 0


def missing_by_topic(path):
    missing = Counter()
    for key in (COMMAND, FRAME):
        heard = sequences(path, key)
        missing[key] = heard[-1] - heard[0] + 1 - len(heard)
    return +missing


def lost_by_topic(path):
    return Counter(
        {
            key.removeprefix("lost/"): int(count)
            for part in parts(path)
            for key, count in FileReader(part).metadata()["SUMMARY"].items()
            if key.startswith("lost/")
        }
    )


def test_kill_9_takes_less_than_a_second_and_the_next_recorder_goes_on(start, path, talker, eventually):
    first = start(flush_period_s=0.5)
    eventually(lambda: holds_both(path))
    time.sleep(1)
    killed_ns, said = time.time_ns(), talker.said[COMMAND]
    first.kill()
    first.wait()
    cut = [one for one in FileReader(path).messages() if one.topic == COMMAND]
    numbers = [one.sequence for one in cut]
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert killed_ns - cut[-1].publish_time_ns < SECOND_NS
    assert said - numbers[-1] <= 100
    assert not finished(path)
    assert "SUMMARY" not in FileReader(path).metadata()

    second = start()
    eventually(lambda: len(parts(path)) == 2 and list(FileReader(parts(path)[1]).messages()))
    end(second)
    assert finished(parts(path)[1])
    assert FileReader(parts(path)[1]).metadata()["PART"]["number"] == "2"


def test_a_power_cut_takes_less_than_a_second_and_one_chunk(start, path, synced, talker, eventually):
    process = start(flush_period_s=0.5, chunk_bytes=65536)
    eventually(lambda: synced.exists() and holds_both(path))
    time.sleep(1)
    # nobody has the time to say a word more, and what the device was not told to keep is gone
    cut_ns = time.time_ns()
    process.kill()
    process.wait()
    talker.stop()
    kept_bytes = int(synced.read_text().split()[-1])
    assert kept_bytes <= path.stat().st_size
    os.truncate(path, kept_bytes)
    numbers = sequences(path, COMMAND)
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert cut_ns - max(one.publish_time_ns for one in FileReader(path).messages()) < SECOND_NS


def test_a_slow_disk_loses_nothing_and_is_still_answered_for(start, ask, path, stall, talker, eventually):
    process = start()
    eventually(lambda: holds_both(path))
    stall.touch()
    size = path.stat().st_size
    before = dict(talker.said)
    time.sleep(3)
    assert path.stat().st_size == size
    reply = ask("status")
    assert (reply.accepted, reply.state) == (True, "recording")
    assert " 0 publications lost" in reply.reason
    stall.unlink()
    assert talker.said[COMMAND] - before[COMMAND] > 150
    eventually(lambda: sequences(path, COMMAND)[-1] > talker.said[COMMAND] - 50)
    end(process)
    assert missing_by_topic(path) == {}
    assert lost_by_topic(path) == {}
    during = [
        one for one in FileReader(path).messages() if before[COMMAND] <= one.sequence and one.topic == COMMAND
    ]
    assert max(late.log_time_ns - late.publish_time_ns for late in during) < SECOND_NS


def test_what_a_frozen_recorder_misses_is_counted_and_nobody_waits_for_it(start, path, talker, eventually):
    process = start(ring_depth=16)
    eventually(lambda: holds_both(path))
    before, since_s = talker.said[COMMAND], time.monotonic()
    process.send_signal(signal.SIGSTOP)
    time.sleep(3)
    process.send_signal(signal.SIGCONT)
    rate_hz = (talker.said[COMMAND] - before) / (time.monotonic() - since_s)
    assert rate_hz > 50
    thawed = talker.said[COMMAND]
    eventually(lambda: sequences(path, COMMAND)[-1] > thawed + 50)
    end(process)
    missing = missing_by_topic(path)
    assert missing[FRAME] > 10
    assert lost_by_topic(path) == missing
    told = [line for line in lines(path) if line.startswith("recording: camera/left:") and "lost" in line]
    assert told
    frozen = range(before - 20, thawed + 50)
    heard = set(sequences(path, COMMAND))
    assert all(number in heard for number in range(min(heard), max(heard)) if number not in frozen)


def test_a_full_disk_ends_the_recording_and_not_the_recorder(start, ask, path, disk, talker, eventually):
    process = start(disk / "full.mcap")
    eventually(lambda: ask("status").state == "waiting")
    reply = ask("status")
    assert "no room is left (" in reply.reason
    assert "publications are lost with it" in reply.reason
    kept = sequences(disk / "full.mcap", COMMAND)
    assert kept == list(range(kept[0], kept[-1] + 1))
    reply = ask("start", path)
    assert (reply.accepted, reply.state) == (True, "recording")
    eventually(lambda: holds_both(path))
    end(process)
    assert finished(path)
    assert missing_by_topic(path) == {}


def test_a_disk_that_fills_ends_the_recording_before_it_is_full(start, ask, mounted, talker, eventually):
    disk = mounted("size=8m")
    if disk is None:
        pytest.skip("only root may mount a small disk")
    process = start(disk / "a.mcap", least_free_bytes=4 * 10**6)
    eventually(lambda: ask("status").state == "waiting")
    assert "least_free_bytes" in ask("status").reason
    eventually(lambda: finished(disk / "a.mcap"))
    assert "least_free_bytes" in FileReader(disk / "a.mcap").metadata()["SUMMARY"]["ended_because"]
    assert any("least_free_bytes" in line for line in lines(disk / "a.mcap"))
    refused = ask("start", disk / "b.mcap")
    assert (refused.accepted, refused.state) == (False, "waiting")
    assert not (disk / "b.mcap").exists()
    used_s = cpu_s(process.pid)
    time.sleep(1)
    assert cpu_s(process.pid) - used_s < 0.7, "it shall not spin"
    end(process)


def cpu_s(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_a_read_only_folder_is_refused_and_the_recorder_lives_on(
    start, ask, path, mounted, talker, eventually
):
    folder = mounted("ro")
    if folder is None:
        folder = path.parent / "mounted"
        folder.chmod(0o555)
    process = start("", begin="on request")
    refused = ask("start", folder / "a.mcap")
    assert (refused.accepted, refused.state) == (False, "waiting")
    assert "mounted/a.mcap: it cannot be written: " in refused.reason
    assert ask("start", path).accepted
    eventually(lambda: holds_both(path))
    end(process)
    assert missing_by_topic(path) == {}


def test_a_folder_that_is_deleted_comes_back_and_the_recording_goes_on(
    start, ask, tmp_path, talker, eventually
):
    path = tmp_path / "folder" / "a.mcap"
    path.parent.mkdir()
    process = start(path)
    eventually(lambda: holds_both(path))
    shutil.rmtree(path.parent)
    deleted = talker.said[COMMAND]
    eventually(lambda: path.exists() and holds_both(path))
    end(process)
    numbers = sequences(path, COMMAND)
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert numbers[0] - deleted < 100
    assert any("it was deleted after" in line and "publications are lost" in line for line in lines(path))


def test_parts_of_a_recorder_at_work_lose_nothing_between_them(start, path, talker, eventually):
    process = start(rotate_s=0.5, rotate_bytes=0)
    eventually(lambda: len(parts(path)) >= 4)
    end(process)
    assert missing_by_topic(path) == {}
    assert all(finished(part) for part in parts(path))
    names = [FileReader(part).metadata()["SUMMARY"].get("goes_on_in") for part in parts(path)]
    assert names == [*(part.name for part in parts(path)[1:]), None]
    for part, following in itertools.pairwise(parts(path)):
        last, first = list(FileReader(part).messages())[-1], next(FileReader(following).messages())
        assert last.log_time_ns <= first.log_time_ns
