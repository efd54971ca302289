"""What is asked of a recorder that runs: start, stop, save, status; and what it does when the controller faults."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from messaging.control import ControllerState, State
from messaging.recorder import RecorderAction, RecorderRequest
from messaging.session import open_session
from messaging.topics import ASKED, CONTROLLER_STATE, RECORDER_DO, TENDON_COMMAND
from recordings import process
from recordings.file_reader import FileReader
from recordings.settings import RecorderSettings
from recordings.source import finished


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "recordings"


@pytest.fixture
def recorder(zenoh_settings, bus, folder):
    """Run a recorder that begins on request, in a thread."""
    folder.mkdir()
    stop = threading.Event()
    pool = ThreadPoolExecutor()

    def work(settings):
        with open_session(zenoh_settings, "bench", "record") as session:
            process.run(settings, None, {}, session, stop, lambda: None)

    def start(**chosen):
        settings = {"folder": str(folder), "begin": "on request", "flush_period_s": 0.1, **chosen}
        return pool.submit(work, RecorderSettings(**settings))

    yield start
    stop.set()
    pool.shutdown()


@pytest.fixture
def ask(bus):
    def say(action, file=""):
        return bus.ask(RECORDER_DO, RecorderRequest(action=RecorderAction(action), file=file), 15.0)

    return say


@pytest.fixture
def asked(bus):
    return bus.every(ASKED, 100)


def commands(path):
    return [one.sequence for one in FileReader(path).messages([TENDON_COMMAND])]


def test_it_waits_until_it_is_asked_and_ends_when_it_is_asked(recorder, ask, folder, talker, eventually):
    recorder()
    assert (ask("status").accepted, ask("status").state) == (True, "waiting")
    assert list(folder.iterdir()) == []
    reply = ask("start", "circle.mcap")
    assert (reply.accepted, reply.state) == (True, "recording")
    assert str(folder / "circle.mcap") in reply.reason
    eventually(lambda: commands(folder / "circle.mcap"))
    again = ask("start")
    assert (again.accepted, again.state) == (False, "recording")
    assert "a recording is going on" in again.reason
    reply = ask("stop")
    assert (reply.accepted, reply.state) == (True, "waiting")
    assert "circle.mcap ended (" in reply.reason
    assert "0 publications lost" in reply.reason
    assert finished(folder / "circle.mcap")
    again = ask("stop")
    assert (again.accepted, again.reason) == (False, "nothing is being recorded")
    numbers = commands(folder / "circle.mcap")
    assert numbers == list(range(numbers[0], numbers[-1] + 1))


def test_a_recording_is_never_overwritten_and_gets_a_name_of_its_own(recorder, ask, folder):
    recorder()
    for name in ("a.mcap", ""):
        assert ask("start", name).accepted
        assert ask("stop").accepted
    before = (folder / "a.mcap").read_bytes()
    refused = ask("start", "a.mcap")
    assert (refused.accepted, refused.state) == (False, "waiting")
    assert "a.mcap: it is finished, and recordings are never overwritten" in refused.reason
    assert (folder / "a.mcap").read_bytes() == before
    assert len(list(folder.iterdir())) == 2


def test_the_last_seconds_are_saved_on_request(recorder, ask, folder, talker, eventually):
    recorder(rolling_s=60, rolling_follow_s=0.3)
    eventually(lambda: "MB kept in memory" in ask("status").reason and talker.said["tendon/command"] > 150)
    said = talker.said["tendon/command"]
    reply = ask("save", "saved.mcap")
    assert (reply.accepted, reply.state) == (True, "saving")
    eventually(lambda: ask("status").state == "waiting" and finished(folder / "saved.mcap"))
    numbers = commands(folder / "saved.mcap")
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert numbers[0] <= said - 100
    assert numbers[-1] >= said + 10


def test_what_cannot_be_saved_is_refused_with_the_reason(recorder, ask, folder):
    recorder()
    assert "recorder.rolling_s = 0" in ask("save").reason
    assert not ask("save").accepted
    assert ask("start", "a.mcap").accepted
    refused = ask("save")
    assert (refused.accepted, refused.state) == (False, "recording")
    assert "everything is being recorded already" in refused.reason


@pytest.fixture
def fall_into_fault(bus, ask, as_message):
    """Say that the controller tracks, and then that it is in fault."""
    states = bus.publisher(CONTROLLER_STATE)

    def say(state, reason):
        states.put(as_message(ControllerState.protobuf(state=state, reason=reason).SerializeToString()))
        # what is said before a question is heard before its answer
        assert ask("status").accepted

    def fall():
        say(State.TRACKING, "")
        for _ in range(5):
            say(State.FAULT, "servo 3 is hot")

    return fall


def test_a_fault_of_the_controller_saves_the_last_seconds(
    recorder, ask, fall_into_fault, folder, talker, eventually
):
    recorder(rolling_s=60, rolling_follow_s=0.3)
    eventually(lambda: "MB kept in memory" in ask("status").reason and talker.said["tendon/command"] > 150)
    said = talker.said["tendon/command"]
    fall_into_fault()
    eventually(lambda: list(folder.iterdir()))
    [saved] = folder.iterdir()
    eventually(lambda: finished(saved))
    assert saved.name.endswith("Z-fault.mcap")
    because = FileReader(saved).metadata()["PART"]["because"]
    assert because == "the controller's state became fault: servo 3 is hot"
    assert commands(saved)[0] <= said - 100
    assert list(folder.iterdir()) == [saved]


def test_a_fault_saves_nothing_where_nothing_is_kept(recorder, fall_into_fault, folder, talker):
    recorder()
    fall_into_fault()
    assert list(folder.iterdir()) == []


def test_every_answer_is_said_to_all(recorder, ask, asked, eventually):
    recorder()
    eventually(lambda: ask("status").accepted and (heard := asked.take()) and heard.key == "asked")
    while asked.take():
        pass
    replies = [ask(action) for action in ("stop", "start", "stop")]
    heard = []
    eventually(lambda: len(heard) == 3 or ((one := asked.take()) and heard.append(one)))
    told = [ASKED.type.from_bytes(one.payload) for one in heard]
    assert [(one.accepted, one.state, one.reason) for one in told] == [
        (reply.accepted, reply.state, reply.reason) for reply in replies
    ]
    assert {one.service for one in told} == {RECORDER_DO.key}
    assert [RecorderRequest.from_bytes(one.request).action for one in told] == ["stop", "start", "stop"]


def test_what_is_no_request_is_refused(recorder, bus, as_message):
    recorder()
    for content in (b"\xff", RecorderRequest.protobuf(action="explode").SerializeToString()):
        reply = bus.ask(RECORDER_DO, as_message(content), 15.0)
        assert not reply.accepted
        assert reply.state == "waiting"
    assert "explode" in reply.reason
