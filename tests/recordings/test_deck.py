"""What the recorder does when it is asked, when the disk is full, and when its files vanish: without a bus, with real files."""

import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from mcap.reader import make_reader

from messaging.session import Received
from messaging.topics import LOG, TARGET, TENDON_COMMAND
from recordings import deck as deck_module
from recordings.backlog import Backlog, Heard
from recordings.deck import Deck
from recordings.errors import DiskFullError, RecordingExistsError, UnwritableError
from recordings.file_reader import FileReader
from recordings.parts import parts
from recordings.settings import RecorderSettings
from recordings.source import finished

SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * SECOND_NS
ATTACHED = {"bench.toml": b"name = 'bench'"}
KILOBYTE = bytes(1000)


class Bench:
    """A deck whose publications and time come from the test; each publication is 1 ms after the one before."""

    def __init__(self, folder, **chosen):
        settings = RecorderSettings(
            **{"folder": str(folder), "least_free_bytes": 0, "chunk_bytes": 4096, **chosen}
        )
        self.backlog = Backlog(settings.memory_bytes)
        self.deck = Deck(settings, ATTACHED, self.backlog)
        self.now_ns = START_NS
        self.next = 0

    def hear(self, count=1, topic=TENDON_COMMAND, payload=KILOBYTE, sequence=None):
        for _ in range(count):
            self.now_ns += SECOND_NS // 1000
            received = Received(
                key=topic.key,
                payload=payload,
                sequence=self.next if sequence is None else sequence,
                publish_time_ns=self.now_ns - 1000,
                epoch=1,
            )
            self.next += topic is TENDON_COMMAND
            self.backlog.append(Heard(topic, received, self.now_ns))
            self.deck.step(self.now_ns)

    def wait(self, seconds):
        self.now_ns += int(seconds * SECOND_NS)
        while self.deck.step(self.now_ns):
            pass

    def stop(self):
        self.deck.stop("enough")
        assert self.deck.closed(30)
        return self.deck.last


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def fresh(part):
    """The messages of a part without those that repeat an earlier one's."""
    return list(FileReader(part).messages())[int(FileReader(part).metadata()["PART"]["repeated"]) :]


def commands(path):
    return [one.sequence for part in parts(path) for one in fresh(part) if one.topic == TENDON_COMMAND.key]


def lines(path):
    return [one.message.wire.message for part in parts(path) for one in FileReader(part).messages([LOG])]


def test_parts_follow_one_another_and_lose_nothing(tmp_path, path):
    bench = Bench(tmp_path, rotate_bytes=50_000, flush_period_s=0.001)
    bench.hear(3, TARGET, b"")
    bench.deck.start(path, bench.now_ns, "the test asks")
    bench.hear(100)
    bench.hear(1, TARGET, b"\x0a\x05newer", sequence=1)
    bench.hear(200)
    summary = bench.stop()
    files = parts(path)
    assert len(files) >= 5
    assert commands(path) == list(range(300))
    assert summary.messages[TENDON_COMMAND.key] == 300
    assert summary.lost == {}
    assert summary.size_bytes == sum(file.stat().st_size for file in files)
    for number, part in enumerate(files, 1):
        assert finished(part)
        assert FileReader(part).attachments() == ATTACHED
        notes = FileReader(part).metadata()
        assert "eclipse-zenoh" in notes["VERSIONS"]
        assert (notes["PART"]["number"], notes["PART"]["recording"]) == (str(number), "a.mcap")
        assert notes["SUMMARY"].get("goes_on_in") == (files[number].name if number < len(files) else None)
        assert notes["SUMMARY"].get("ended_because") == ("enough" if number == len(files) else None)
        with part.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            counted = len(list(reader.iter_messages()))
            assert reader.get_summary().statistics.message_count == counted
        first = next(FileReader(part).messages())
        assert first.topic == TARGET.key
        assert first.payload == (b"" if first.sequence == 0 else b"\x0a\x05newer")
        assert first.publish_time_ns < first.log_time_ns
    assert next(FileReader(files[0]).messages()).sequence == 0
    assert next(FileReader(files[-1]).messages()).sequence == 1


def test_reruns_own_reader_finds_nothing_wrong_with_a_part(tmp_path, path):
    bench = Bench(tmp_path, rotate_bytes=50_000, flush_period_s=0.001)
    bench.hear(3, TARGET, b"")
    bench.deck.start(path, bench.now_ns, "the test asks")
    bench.hear(100)
    bench.stop()
    for part in parts(path)[:2]:
        checked = subprocess.run(
            [Path(sys.executable).with_name("rerun"), "mcap", "check", part],
            capture_output=True,
            text=True,
            check=True,
        )
        status = [line.split()[:1] for line in checked.stdout.splitlines() if line.endswith("—")]
        assert status == [["ok"]] * 2


def test_parts_follow_by_time_too(tmp_path, path):
    bench = Bench(tmp_path, rotate_s=1, rotate_bytes=0, flush_period_s=0.1)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(3500, payload=b"")
    bench.stop()
    assert len(parts(path)) == 4
    assert commands(path) == list(range(3500))
    durations = [float(FileReader(part).metadata()["SUMMARY"]["duration_s"]) for part in parts(path)]
    assert all(1 <= duration <= 1.2 for duration in durations[:-1])


def test_a_gap_across_two_parts_is_counted_once(tmp_path, path):
    bench = Bench(tmp_path, rotate_bytes=20_000, flush_period_s=0.01)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(50)
    bench.next += 7
    bench.hear(50)
    summary = bench.stop()
    assert summary.lost == {TENDON_COMMAND.key: 7}
    told = [FileReader(part).metadata()["SUMMARY"].get(f"lost/{TENDON_COMMAND.key}") for part in parts(path)]
    assert [one for one in told if one] == ["7"]
    assert [line for line in lines(path) if "lost" in line] == [
        "recording: tendon/command: 7 lost (sequence 50 to 56)"
    ]


def test_a_next_part_that_cannot_be_does_not_end_the_recording(tmp_path, path):
    bench = Bench(tmp_path, rotate_bytes=20_000, flush_period_s=0.01)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(10)
    (tmp_path / "a.part2.mcap").write_bytes(b"somebody else's")
    bench.hear(90)
    bench.stop()
    assert (tmp_path / "a.part2.mcap").read_bytes() == b"somebody else's"
    assert [one.sequence for one in FileReader(path).messages([TENDON_COMMAND])] == list(range(100))
    told = [one.message.wire.message for one in FileReader(path).messages([LOG])]
    assert len([line for line in told if "there can be no next" in line]) == 1


def test_below_the_bound_of_free_space_the_recording_ends_in_good_order(tmp_path, path, monkeypatch):
    free = 10**9
    monkeypatch.setattr(deck_module, "free_bytes", lambda _: free)
    bench = Bench(tmp_path, least_free_bytes=5 * 10**8, flush_period_s=0.01)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(50)
    free = 4 * 10**8
    bench.hear(50)
    assert bench.deck.state == "waiting"
    assert (
        "only 400.0 MB is left on the disk, and recorder.least_free_bytes = 500000000"
        in bench.deck.describe()
    )
    assert bench.deck.closed(30)
    assert finished(path)
    assert "only 400.0 MB is left" in FileReader(path).metadata()["SUMMARY"]["ended_because"]
    assert any("only 400.0 MB is left" in line for line in lines(path))
    assert len(commands(path)) >= 50
    with pytest.raises(DiskFullError, match="least_free_bytes"):
        bench.deck.start(tmp_path / "b.mcap", bench.now_ns, "")
    assert not (tmp_path / "b.mcap").exists()
    free = 10**9
    bench.deck.start(tmp_path / "b.mcap", bench.now_ns, "")
    assert bench.deck.state == "recording"


def test_a_full_disk_ends_the_recording_and_says_what_it_cost(tmp_path, path, small_disk, eventually):
    bench = Bench(tmp_path)
    bench.deck.start(path, bench.now_ns, "")
    with small_disk(50_000):
        eventually(lambda: bench.hear() or bench.deck.state == "waiting")
    said = bench.next
    kept = commands(path)
    assert kept == list(range(len(kept)))
    lost = said - len(kept) - bench.backlog.size_bytes // (1000 + 500)
    assert "no room is left (File too large)" in bench.deck.describe()
    assert f"{lost} publications are lost with it" in bench.deck.describe()
    bench.deck.start(tmp_path / "b.mcap", bench.now_ns, "")
    assert bench.deck.state == "recording"


def test_a_deleted_folder_is_made_again_and_the_recording_goes_on(tmp_path, eventually):
    path = tmp_path / "folder" / "a.mcap"
    path.parent.mkdir()
    bench = Bench(tmp_path, flush_period_s=0.01)
    bench.hear(1, TARGET, b"")
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(30)
    path.unlink()
    path.parent.rmdir()
    eventually(lambda: bench.hear() or path.exists())
    bench.hear(30)
    bench.stop()
    kept = commands(path)
    assert kept[-1] == bench.next - 1
    assert kept == list(range(kept[0], bench.next))
    assert "it was deleted after" in FileReader(path).metadata()["PART"]["because"]
    assert any("it was deleted after" in line and "publications are lost" in line for line in lines(path))
    assert next(FileReader(path).messages()).topic == TARGET.key


def test_what_cannot_be_begun_is_refused_and_changes_nothing(tmp_path, path):
    bench = Bench(tmp_path)
    path.write_bytes(b"")
    with pytest.raises(UnwritableError, match=r"the folder .*/nowhere does not exist"):
        bench.deck.start(tmp_path / "nowhere" / "a.mcap", bench.now_ns, "")
    bench.deck.start(path, bench.now_ns, "")
    bench.stop()
    with pytest.raises(RecordingExistsError):
        bench.deck.start(path, bench.now_ns, "")
    assert bench.deck.state == "waiting"


def test_the_last_seconds_are_saved_with_those_that_follow(tmp_path, path):
    bench = Bench(tmp_path, rolling_s=2, rolling_follow_s=1)
    bench.hear(1, TARGET, b"")
    bench.hear(5000, payload=b"")
    bench.deck.save(path, bench.now_ns, "the test asks", "saved")
    assert bench.deck.state == "saving"
    bench.hear(2000, payload=b"")
    assert bench.deck.state == "waiting"
    assert bench.deck.closed(30)
    assert commands(path) == list(range(2999, 6000))
    assert next(FileReader(path).messages()).topic == TARGET.key
    times = [one.log_time_ns for one in FileReader(path).messages()]
    assert times == sorted(times)
    assert FileReader(path).metadata()["PART"]["because"] == "the test asks"


def test_saves_that_follow_one_another_adjoin(tmp_path):
    bench = Bench(tmp_path, rolling_s=2, rolling_follow_s=0.5)
    bench.hear(1000, payload=b"")
    bench.deck.save(tmp_path / "a.mcap", bench.now_ns, "", "")
    bench.hear(300, payload=b"")
    bench.deck.save(tmp_path / "longer.mcap", bench.now_ns, "", "")
    bench.hear(1000, payload=b"")
    bench.deck.save(tmp_path / "b.mcap", bench.now_ns, "", "")
    bench.wait(1)
    assert bench.deck.closed(30)
    assert commands(tmp_path / "a.mcap") + commands(tmp_path / "b.mcap") == list(range(2300))
    assert len(commands(tmp_path / "a.mcap")) == 1800
    assert not (tmp_path / "longer.mcap").exists()


def test_a_recording_that_is_asked_for_ends_a_save(tmp_path):
    bench = Bench(tmp_path, rolling_s=2)
    bench.hear(100)
    bench.deck.save(tmp_path / "a.mcap", bench.now_ns, "", "")
    bench.hear(100)
    bench.deck.start(tmp_path / "b.mcap", bench.now_ns, "")
    bench.hear(100)
    bench.stop()
    assert commands(tmp_path / "a.mcap") == list(range(200))
    assert commands(tmp_path / "b.mcap") == list(range(200, 300))


def test_a_recording_begins_when_it_is_asked_for_and_not_with_what_was_kept(tmp_path, path):
    bench = Bench(tmp_path, rolling_s=2)
    bench.hear(100)
    bench.wait(0.1)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(10)
    bench.stop()
    assert commands(path) == list(range(100, 110))


def test_nothing_is_kept_unless_that_is_asked_for(tmp_path, path):
    bench = Bench(tmp_path)
    bench.hear(100)
    assert bench.backlog.size_bytes <= 1500
    bench.wait(0.1)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(10)
    bench.stop()
    assert commands(path) == list(range(100, 110))


def test_a_save_is_written_in_steps_so_that_hearing_goes_on(tmp_path, path, monkeypatch):
    monkeypatch.setattr(deck_module, "STEP_BYTES", 100_000)
    bench = Bench(tmp_path, rolling_s=10)
    bench.hear(1000)
    bench.deck.save(path, bench.now_ns, "", "")
    steps = 0
    while bench.deck.step(bench.now_ns):
        steps += 1
    assert 9 <= steps <= 11


@pytest.fixture
def stalled(monkeypatch):
    """A disk that does nothing until the event is set."""
    free = threading.Event()
    pwrite = os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda *arguments: free.wait(30) and pwrite(*arguments))
    yield free
    free.set()


def test_a_stalled_disk_costs_nothing_that_memory_can_hold(tmp_path, path, stalled, monkeypatch):
    monkeypatch.setattr(deck_module, "WRITE_AHEAD_BYTES", 100_000)
    bench = Bench(tmp_path)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(1000)
    assert bench.backlog.size_bytes >= 800_000
    assert not bench.deck.step(bench.now_ns), "it shall not spin while the disk stalls"
    stalled.set()
    bench.stop()
    assert commands(path) == list(range(1000))


def test_what_memory_cannot_hold_is_dropped_and_counted(tmp_path, path, stalled, monkeypatch, eventually):
    monkeypatch.setattr(deck_module, "WRITE_AHEAD_BYTES", 100_000)
    bench = Bench(tmp_path, memory_bytes=2**20)
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(2000)
    stalled.set()
    eventually(lambda: not bench.wait(0.1) and bench.backlog.first_ns is None)
    summary = bench.stop()
    kept = commands(path)
    missing = 2000 - len(kept)
    assert missing > 1000
    assert summary.lost == {TENDON_COMMAND.key: missing}
    assert kept[-1] == 1999
    told = [re.search(r"waited, and (\d+) publications were dropped", line) for line in lines(path)]
    assert sum(int(match[1]) for match in told if match) == missing


def test_how_things_stand_is_said_in_words(tmp_path, path):
    bench = Bench(tmp_path, rolling_s=2)
    assert "nothing was asked for yet" in bench.deck.describe()
    bench.deck.start(path, bench.now_ns, "")
    bench.hear(500)
    bench.next += 3
    bench.hear(501)
    bench.wait(1)
    bench.wait(1)
    for words in (str(path), "1.0 s", "MB", "3 publications lost", "GB free"):
        assert words in bench.deck.describe()
    bench.stop()
    assert "a.mcap ended (1.0 s" in bench.deck.describe()
    assert bench.deck.describe().count("enough") == 1
