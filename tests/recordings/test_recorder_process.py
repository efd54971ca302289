"""The recorder on a real bus, writing real files: nothing is lost, what is lost is counted, and it ends well."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import zenoh
from mcap.reader import make_reader

from messaging.session import open_session
from messaging.topics import CAMERA, LOG, SIMULATED_CAMERA, TENDON_COMMAND, TOPICS
from recordings import process
from recordings.errors import RecordingExistsError, RecordingInUseError
from recordings.file_reader import FileReader
from recordings.settings import RecorderSettings
from recordings.source import finished

ATTACHED = {"bench.toml": b"name = 'bench'", "calibration.json": b"{}"}
LOGGED = [topic.named("left") for topic in TOPICS if topic.logged]
JPEG_SIZED = bytes(range(256)) * 1200


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def recorder(zenoh_settings, path):
    """Start the recorder in a thread: a future of its summary. All of them are stopped by the event."""
    stop = threading.Event()
    pool = ThreadPoolExecutor()

    def work(healthy, settings):
        with open_session(zenoh_settings, "bench", "record") as session:
            return process.run(settings, path, ATTACHED, session, stop, healthy)

    def start(healthy=lambda: None, **chosen):
        return pool.submit(work, healthy, RecorderSettings(flush_period_s=0.1, **chosen))

    start.stop = stop
    yield start
    stop.set()
    pool.shutdown()


@pytest.fixture
def reaches(path, eventually, as_message):
    """Publish until the recording holds something of this topic."""

    def wait(publisher, key, content=b""):
        def arrived():
            publisher.put(as_message(content))
            return path.exists() and any(one.topic == key for one in FileReader(path).messages())

        eventually(arrived)

    return wait


def test_every_logged_topic_arrives_byte_for_byte(bus, path, recorder, reaches, as_message):
    running = recorder()
    publishers = {topic.key: bus.publisher(topic) for topic in LOGGED}
    unlogged = bus.publisher(SIMULATED_CAMERA.named("left"))
    for key, publisher in publishers.items():
        reaches(publisher, key, b"first")
    said = {key: [] for key in publishers}
    for number in range(60):
        for key, publisher in publishers.items():
            payload = key.encode() + bytes([number]) + (JPEG_SIZED if key == "camera/left" else b"")
            said[key].append(payload)
            publisher.put(as_message(payload))
        unlogged.put(as_message(b"not logged"))
        time.sleep(0.01)
    for key, publisher in publishers.items():
        reaches_end(publisher, path, key, as_message)
    recorder.stop.set()
    summary = running.result(30)

    heard = {key: [] for key in publishers}
    for one in FileReader(path).messages():
        heard[one.topic].append(one.payload)
    kept = {key: [p for p in payloads if p not in (b"first", b"end")] for key, payloads in heard.items()}
    assert kept == said
    assert summary.lost == {}
    assert summary.messages == {key: len(payloads) for key, payloads in heard.items()}
    assert summary.size_bytes == path.stat().st_size
    assert FileReader(path).attachments() == ATTACHED
    assert FileReader(path).metadata()["SUMMARY"]["messages/camera/left"] == str(
        summary.messages["camera/left"]
    )
    assert "eclipse-zenoh" in FileReader(path).metadata()["VERSIONS"]
    assert finished(path)
    with path.open("rb") as file:
        statistics = make_reader(file).get_summary().statistics
    assert statistics.message_count == sum(summary.messages.values())


def reaches_end(publisher, path, key, as_message):
    deadline = time.monotonic() + 15
    publisher.put(as_message(b"end"))
    while not any(one.topic == key and one.payload == b"end" for one in FileReader(path).messages()):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_sequence_numbers_and_times_are_those_of_the_publisher(bus, path, recorder, reaches, as_message):
    running = recorder()
    publisher = bus.publisher(CAMERA.named("left"))
    reaches(publisher, "camera/left")
    before_ns = time.time_ns()
    publisher.put(as_message(b"numbered"), sequence=2**32 + 5)
    after_ns = time.time_ns()
    reaches(publisher, "camera/left")
    recorder.stop.set()
    running.result(30)
    one = next(one for one in FileReader(path).messages() if one.payload == b"numbered")
    assert one.sequence == 5
    assert before_ns <= one.publish_time_ns <= after_ns
    assert one.log_time_ns >= one.publish_time_ns - 1_000_000_000


def test_what_a_stalled_recorder_loses_is_counted_in_the_log_itself(bus, path, recorder, reaches, as_message):
    free = threading.Event()
    free.set()
    stalled = threading.Event()

    def healthy():
        if not free.is_set():
            stalled.set()
            free.wait(30)

    running = recorder(healthy, ring_depth=16)
    publisher = bus.publisher(TENDON_COMMAND)
    reaches(publisher, TENDON_COMMAND.key)
    free.clear()
    assert stalled.wait(30)
    for _ in range(200):
        publisher.put(as_message(b"burst"))
    publisher.put(as_message(b"last of the burst"))
    time.sleep(0.5)
    free.set()
    reaches_end(publisher, path, TENDON_COMMAND.key, as_message)
    recorder.stop.set()
    summary = running.result(30)

    sequences = [one.sequence for one in FileReader(path).messages([TENDON_COMMAND])]
    missing = sequences[-1] - sequences[0] + 1 - len(sequences)
    assert missing > 100
    assert summary.lost == {TENDON_COMMAND.key: missing}
    assert FileReader(path).metadata()["SUMMARY"][f"lost/{TENDON_COMMAND.key}"] == str(missing)
    lines = [one.message.wire for one in FileReader(path).messages([LOG])]
    assert any(f"tendon/command: {missing} lost (sequence" in line.message for line in lines)
    assert {line.name for line in lines} == {"record"}


def test_a_publication_from_outside_is_told_of_and_ends_nothing(zenoh_settings, bus, path, recorder, reaches):
    running = recorder()
    config = f'{{mode: "client", connect: {{endpoints: ["{zenoh_settings.rendezvous}"]}}}}'
    with zenoh.open(zenoh.Config.from_json5(config)) as foreign:
        deadline = time.monotonic() + 15
        told = False
        while not told:
            assert time.monotonic() < deadline
            foreign.put("nodal/bench/tendon/command", b"hello")
            time.sleep(0.05)
            told = path.exists() and any(
                "no envelope" in one.message.wire.message for one in FileReader(path).messages([LOG])
            )
    reaches(bus.publisher(TENDON_COMMAND), TENDON_COMMAND.key)
    recorder.stop.set()
    assert running.result(30).lost == {}


def test_two_recorders_do_not_share_a_file(bus, recorder, reaches):
    first = recorder()
    reaches(bus.publisher(TENDON_COMMAND), TENDON_COMMAND.key)
    with pytest.raises(RecordingInUseError, match="another recorder is writing it"):
        recorder().result(30)
    recorder.stop.set()
    first.result(30)
    with pytest.raises(RecordingExistsError, match="it is finished"):
        recorder().result(30)
