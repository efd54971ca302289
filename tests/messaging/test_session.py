"""Real Zenoh sessions: processes meet in any order, nothing old is taken for new, nothing blocks."""

import contextlib
import gc
import itertools
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import zenoh

from messaging.control import Action, ActionRequest, Reply, TendonCommand
from messaging.errors import CodecError, EndpointError, UnansweredError
from messaging.session import open_rendezvous, open_session
from messaging.settings import ZenohSettings
from messaging.topics import CAMERA, CONTROLLER_DO, TENDON_COMMAND

COMMAND = TendonCommand(
    time_ns=1, displacement_mm=[1, 2, 3, 4], insertion_mm=5.0, shape_sequence=6, capture_to_command_ns=7
)
STATUS = ActionRequest(action=Action.STATUS)
IDLE = Reply(accepted=True, state="idle", reason="")

RENDEZVOUS = """
import sys, time
from messaging.session import open_rendezvous
from messaging.settings import ZenohSettings
with open_rendezvous(ZenohSettings(rendezvous=sys.argv[1]), "bench"):
    print("open", flush=True)
    time.sleep(60)
"""

FROZEN = """
import sys, time
from messaging.session import open_session
from messaging.settings import ZenohSettings
from messaging.topics import TENDON_COMMAND
with open_session(ZenohSettings(rendezvous=sys.argv[1]), "bench", "frozen") as session:
    ring = session.every(TENDON_COMMAND, 16)
    while ring.take() is None:
        time.sleep(0.01)
    print("hears", flush=True)
    time.sleep(60)
"""


@contextlib.contextmanager
def python(code, *arguments):
    """A Python process that has printed its first line; killed at the end."""
    with subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, text=True
    ) as child:
        try:
            yield child
        finally:
            child.kill()


def hear(ring, publisher, eventually):
    """Publish until the other end hears."""

    def once():
        publisher.put(COMMAND)
        return ring.take()

    return eventually(once)


@pytest.mark.parametrize("order", list(itertools.permutations(["rendezvous", "speaker", "listener"])))
def test_processes_meet_in_any_order(order, zenoh_settings, eventually):
    with contextlib.ExitStack() as stack:
        sessions = {
            name: stack.enter_context(
                open_rendezvous(zenoh_settings, "bench")
                if name == "rendezvous"
                else open_session(zenoh_settings, "bench", name)
            )
            for name in order
        }
        ring = sessions["listener"].every(TENDON_COMMAND, 100)
        received = hear(ring, sessions["speaker"].publisher(TENDON_COMMAND), eventually)
        assert received.key == "tendon/command"
        assert received.payload == COMMAND.to_bytes()
        assert abs(time.time_ns() - received.publish_time_ns) < 60e9


def test_peers_talk_on_without_their_rendezvous_and_meet_newcomers_when_it_is_back(
    zenoh_settings, eventually
):
    with contextlib.ExitStack() as stack:
        with python(RENDEZVOUS, zenoh_settings.rendezvous) as rendezvous:
            assert rendezvous.stdout.readline() == "open\n"
            speaker = stack.enter_context(open_session(zenoh_settings, "bench", "speaker"))
            listener = stack.enter_context(open_session(zenoh_settings, "bench", "listener"))
            ring, publisher = listener.every(TENDON_COMMAND, 100), speaker.publisher(TENDON_COMMAND)
            hear(ring, publisher, eventually)
            eventually(lambda: speaker.alive() >= {"speaker", "listener"})
        while ring.take() is not None:
            pass
        hear(ring, publisher, eventually)
        stack.enter_context(open_rendezvous(zenoh_settings, "bench"))
        newcomer = stack.enter_context(open_session(zenoh_settings, "bench", "newcomer"))
        hear(newcomer.every(TENDON_COMMAND, 100), publisher, eventually)


@pytest.fixture
def pair(zenoh_settings):
    """A speaker and a listener that know each other."""
    with (
        open_rendezvous(zenoh_settings, "bench"),
        open_session(zenoh_settings, "bench", "speaker") as speaker,
        open_session(zenoh_settings, "bench", "listener") as listener,
    ):
        yield speaker, listener


def test_newest_hands_out_the_newest_and_nothing_older(pair, eventually):
    speaker, listener = pair
    newest, every = listener.newest(TENDON_COMMAND), listener.every(TENDON_COMMAND, 10_000)
    publisher = speaker.publisher(TENDON_COMMAND)
    last = hear(every, publisher, eventually).sequence
    for _ in range(50):
        publisher.put(COMMAND)
        last += 1
    eventually(lambda: (heard := every.take()) is not None and heard.sequence >= last)
    # both rings are filled by the same publications, one just after the other
    message, _ = eventually(lambda: (taken := newest.take()) and taken[1].sequence >= last and taken)
    assert message == COMMAND
    assert newest.take() is None


def test_what_a_ring_had_no_room_for_shows_as_a_gap(pair, eventually):
    speaker, listener = pair
    short, long = listener.every(TENDON_COMMAND, 4), listener.every(TENDON_COMMAND, 10_000)
    publisher = speaker.publisher(TENDON_COMMAND)
    first = hear(long, publisher, eventually)
    for _ in range(20):
        publisher.put(COMMAND)
    eventually(lambda: (heard := long.take()) is not None and heard.sequence >= first.sequence + 20)
    kept = [short.take() for _ in range(4)]
    assert short.take() is None
    numbers = [received.sequence for received in kept]
    assert numbers == list(range(numbers[0], numbers[0] + 4))
    assert numbers[0] > first.sequence + 1
    assert {received.epoch for received in kept} == {first.epoch}


def test_a_caller_may_number_its_messages(pair, eventually):
    speaker, listener = pair
    ring, publisher = listener.every(TENDON_COMMAND, 10_000), speaker.publisher(TENDON_COMMAND)
    hear(ring, publisher, eventually)
    publisher.put(COMMAND, sequence=2**40)
    publisher.put(COMMAND)
    eventually(lambda: (heard := ring.take()) is not None and heard.sequence == 2**40)
    assert eventually(ring.take).sequence == 2**40 + 1


def test_bytes_go_out_as_they_are_and_as_new(pair, eventually):
    speaker, listener = pair
    ring, publisher = listener.every(TENDON_COMMAND, 10_000), speaker.publisher(TENDON_COMMAND)
    hear(ring, publisher, eventually)
    before_ns = time.time_ns()
    publisher.put_bytes(b"as recorded", 7)
    received = eventually(lambda: (heard := ring.take()) and heard.sequence == 7 and heard)
    assert received.payload == b"as recorded"
    assert before_ns <= received.publish_time_ns <= time.time_ns()


def test_each_start_of_a_publisher_is_an_epoch_of_its_own(pair, eventually):
    speaker, listener = pair
    ring = listener.every(TENDON_COMMAND, 100)
    first = hear(ring, speaker.publisher(TENDON_COMMAND), eventually)
    other = speaker.publisher(TENDON_COMMAND)
    eventually(lambda: hear(ring, other, eventually).epoch != first.epoch)


def test_presence_hears_who_was_there_who_comes_and_who_goes(zenoh_settings, eventually):
    with (
        open_rendezvous(zenoh_settings, "bench"),
        open_session(zenoh_settings, "bench", "first"),
        open_session(zenoh_settings, "bench", "watcher") as watcher,
    ):
        presence = watcher.presence()
        eventually(lambda: presence.alive() == {"rendezvous", "first", "watcher"})
        with open_session(zenoh_settings, "bench", "second"):
            eventually(lambda: "second" in presence.alive())
        eventually(lambda: presence.alive() == {"rendezvous", "first", "watcher"})


def test_a_pattern_hears_every_camera(pair, eventually):
    speaker, listener = pair
    ring = listener.every(CAMERA, 100)
    for name in ("left", "right"):
        publisher = speaker.publisher(CAMERA.named(name))
        eventually(lambda put=publisher.put, key=f"camera/{name}": (put(COMMAND), _next_key(ring))[1] == key)


def _next_key(ring):
    received = ring.take()
    return received and received.key


def test_benches_do_not_hear_each_other(zenoh_settings, eventually):
    with (
        open_rendezvous(zenoh_settings, "bench"),
        open_session(zenoh_settings, "bench", "speaker") as speaker,
        open_session(zenoh_settings, "bench", "listener") as listener,
        open_session(zenoh_settings, "other", "stranger") as stranger,
    ):
        strange, ring = stranger.every(TENDON_COMMAND, 100), listener.every(TENDON_COMMAND, 100)
        publisher = speaker.publisher(TENDON_COMMAND)
        for _ in range(20):
            hear(ring, publisher, eventually)
        assert strange.take() is None


def test_a_publication_from_outside_is_refused_and_does_not_hide_the_next(zenoh_settings, pair, eventually):
    speaker, listener = pair
    ring = listener.every(TENDON_COMMAND, 10_000)
    publisher = speaker.publisher(TENDON_COMMAND)
    hear(ring, publisher, eventually)
    config = f'{{mode: "client", connect: {{endpoints: ["{zenoh_settings.rendezvous}"]}}}}'
    with zenoh.open(zenoh.Config.from_json5(config)) as foreign:

        def refused():
            foreign.put("nodal/bench/tendon/command", b"hello")
            foreign.put("nodal/bench/tendon/command", b"hello", attachment=b"short")
            try:
                ring.take()
            except CodecError as error:
                return str(error)
            return ""

        assert "tendon/command" in eventually(refused)
    seen = []
    while len(seen) < 1000:
        try:
            seen.append(ring.take())
        except CodecError:
            continue
        if seen[-1] is None:
            break
    hear(ring, publisher, eventually)


def test_a_bad_payload_is_a_typed_error_and_the_next_is_read(pair, eventually):
    speaker, listener = pair
    newest = listener.newest(TENDON_COMMAND)
    publisher = speaker.publisher(TENDON_COMMAND)

    class Nonsense:
        def to_bytes(self):
            return b"\xff"

    def refused():
        publisher.put(Nonsense())
        with contextlib.suppress(CodecError):
            newest.take()
            return False
        return True

    eventually(refused)
    eventually(lambda: (publisher.put(COMMAND), _message(newest))[1] == COMMAND)


def _message(newest):
    with contextlib.suppress(CodecError):
        taken = newest.take()
        return taken and taken[0]


def test_an_endpoint_in_use_is_named(zenoh_settings):
    with (
        open_rendezvous(zenoh_settings, "bench"),
        pytest.raises(EndpointError, match=rf"{zenoh_settings.rendezvous} .*in use"),
        open_rendezvous(zenoh_settings, "bench"),
    ):
        pass


def test_an_endpoint_that_cannot_be_is_named():
    with pytest.raises(EndpointError, match=r"tcp/no\.such\.host\.invalid:7447"):
        open_rendezvous(ZenohSettings(rendezvous="tcp/no.such.host.invalid:7447"), "bench").__enter__()


def test_a_question_nobody_answers_ends(zenoh_settings):
    with (
        open_session(zenoh_settings, "bench", "operator") as operator,
        pytest.raises(UnansweredError, match=r"controller/do within 0\.3 s; is the controller running"),
    ):
        operator.ask(CONTROLLER_DO, STATUS, timeout_s=0.3)


ANSWERER = """
import sys, time
from messaging.control import Reply
from messaging.errors import NodalError
from messaging.session import open_session
from messaging.settings import ZenohSettings
from messaging.topics import CONTROLLER_DO
with open_session(ZenohSettings(rendezvous=sys.argv[1]), "bench", "controller") as session:
    answers = session.answers(CONTROLLER_DO)
    while True:
        if (query := answers.take()) is None:
            time.sleep(0.005)
            continue
        try:
            query.reply(Reply(accepted=True, state="idle", reason=query.request().action))
        except NodalError as error:
            query.reply(Reply(accepted=False, state="idle", reason=str(error)))
"""


def test_a_question_waits_for_a_process_that_is_just_starting(zenoh_settings):
    with (
        open_rendezvous(zenoh_settings, "bench") as operator,
        python(ANSWERER, zenoh_settings.rendezvous),
    ):
        reply = operator.ask(CONTROLLER_DO, STATUS, timeout_s=20)
        assert (reply.accepted, reply.reason) == (True, "status")

        class Nonsense:
            def to_bytes(self):
                return b"\xff"

        refused = operator.ask(CONTROLLER_DO, Nonsense(), timeout_s=20)
        assert not refused.accepted
        assert "nodal.ActionRequest" in refused.reason


def test_who_is_alive(zenoh_settings, eventually):
    with open_rendezvous(zenoh_settings, "bench") as rendezvous:
        # nobody holds what is opened here: being alive must not depend on it
        with open_session(zenoh_settings, "bench", "sensing"):
            eventually(lambda: rendezvous.alive() == {"rendezvous", "sensing"})
            gc.collect()
            assert rendezvous.alive() == {"rendezvous", "sensing"}
        eventually(lambda: rendezvous.alive() == {"rendezvous"})


def test_a_frozen_listener_does_not_hold_up_a_publisher(zenoh_settings):
    with (
        open_rendezvous(zenoh_settings, "bench"),
        open_session(zenoh_settings, "bench", "speaker") as speaker,
        python(FROZEN, zenoh_settings.rendezvous) as frozen,
    ):
        publisher = speaker.publisher(TENDON_COMMAND)
        big = TendonCommand(
            time_ns=1,
            displacement_mm=[0.5] * 40_000,
            insertion_mm=5.0,
            shape_sequence=6,
            capture_to_command_ns=7,
        )
        os.set_blocking(frozen.stdout.fileno(), False)
        deadline = time.monotonic() + 20
        while not frozen.stdout.readline():
            assert time.monotonic() < deadline
            publisher.put(COMMAND)
            time.sleep(0.01)
        frozen.send_signal(signal.SIGSTOP)
        slowest_s = 0.0
        for _ in range(100):
            start = time.monotonic()
            publisher.put(big)
            slowest_s = max(slowest_s, time.monotonic() - start)
        # a publisher that waits for its listeners would stand still for 5 s, Zenoh's limit
        assert slowest_s < 2


def test_a_bench_listens_on_loopback_only(pair):
    own = {str(link.readlink()) for link in list(Path("/proc/self/fd").iterdir()) if link.is_symlink()}
    local = set()
    for protocol in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/net/{protocol}").read_text().splitlines()[1:]:
            fields = line.split()
            if f"socket:[{fields[9]}]" in own:
                local.add((protocol, fields[1].partition(":")[0]))
    assert local == {("tcp", "0100007F")}


def test_settings_keep_to_loopback_unless_told_otherwise():
    settings = ZenohSettings()
    assert settings.rendezvous.startswith("tcp/127.0.0.1:")
    assert settings.listen.startswith("tcp/127.0.0.1:")
