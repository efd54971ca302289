"""What is asked of a recorder that runs: start, stop, save, status; and what it does when the controller faults."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from messaging.control import ControllerState, State
from messaging.recorder import RecorderAction, RecorderRequest
from messaging.session import open_session
from messaging.topics import ASKED, CONTROLLER_STATE, RECORDER_DO, TENDON_COMMAND
from recordings import process
from recordings.reader import messages, metadata
from recordings.records import finished
from recordings.settings import RecorderSettings


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
    return [one.sequence for one in messages(path, [TENDON_COMMAND])]


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


def test_a_fault_of_the_controller_saves_the_last_seconds(
    recorder, ask, bus, folder, talker, as_message, eventually
):
    recorder(rolling_s=60, rolling_follow_s=0.3)
    states = bus.publisher(CONTROLLER_STATE)

    def say(state, reason):
        states.put(as_message(ControllerState.protobuf(state=state, reason=reason).SerializeToString()))

    eventually(lambda: "MB kept in memory" in ask("status").reason and talker.said["tendon/command"] > 150)
    eventually(lambda: say(State.TRACKING, "") or states_heard(ask))
    said = talker.said["tendon/command"]
    say(State.FAULT, "servo 3 is hot")
    eventually(lambda: list(folder.iterdir()))
    [saved] = folder.iterdir()
    for _ in range(5):
        say(State.FAULT, "servo 3 is hot")
    eventually(lambda: finished(saved))
    assert saved.name.endswith("Z-fault.mcap")
    assert "the controller's state became fault: servo 3 is hot" in metadata(saved)["PART"]["because"]
    assert commands(saved)[0] <= said - 100
    assert list(folder.iterdir()) == [saved]


def states_heard(ask):
    # the recorder hears within 10 ms, and answers after that
    return ask("status").accepted


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
