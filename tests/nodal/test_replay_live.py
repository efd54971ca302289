"""Live replay over a real bus: same bytes, same numbers, same spacing, ages as fresh - and never beside who says the same."""

import argparse
import contextlib
import itertools
import signal
import statistics
import subprocess
import sys
import threading
import time

import pytest

from messaging import topics
from messaging.control import TendonState
from messaging.session import open_rendezvous, open_session
from messaging.shape import Truth
from nodal.__main__ import main
from nodal.bench_file import bench_path, load_bench
from nodal.errors import ReplayError
from nodal.log.spans import Span
from nodal.replay.live.arguments import add_live_arguments
from nodal.replay.live.guard import Guard
from nodal.replay.live.playing import Playing, play
from nodal.replay.live.topics import DEFAULT, chosen
from nodal.toml_file import read_table, written
from recordings.log import Log
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
MS = 1_000_000


def truth(number):
    return Truth(
        capture_time_ns=number,
        arc_mm=[0.0, 1.0],
        centreline_mm=[[0.0, 0.0, number], [0.0, 0.0, 1.0]],
        insertion_mm=0.0,
    ).to_bytes()


GAPS_MS = (20, 60, 5, 5, 90, 20, 40, 1, 30, 70, 10, 25)
NUMBERS = (5, 6, 8, 9, 10, 11, 12, 13, 0, 1, 2, 4)
"""One was lost, and who said it was started anew."""


@pytest.fixture
def recording(tmp_path):
    """A recording of a few truths, a controller's word, and something else; logged late and unevenly."""
    path = tmp_path / "short.mcap"
    publish_ms = list(itertools.accumulate(GAPS_MS))
    with RecordingWriter(path, RecorderSettings()) as writing:
        for name, data in load_bench("simulated").attachments().items():
            writing.attach(name, data, START_NS)
        log_ns = 0
        for number, at_ms in zip(NUMBERS, publish_ms, strict=True):
            log_ns = max(log_ns, START_NS + (at_ms + 7 * number % 15) * MS)
            for topic, payload in ((topics.TRUTH, truth(at_ms)), (topics.TENDON_STATE, b"")):
                writing.write(
                    topic.key,
                    topic.type.protobuf,
                    payload,
                    sequence=number,
                    publish_time_ns=START_NS + at_ms * MS,
                    log_time_ns=log_ns,
                )
    return path


@pytest.fixture
def bus(zenoh_settings):
    """The replay's session and a listener's, which know each other."""
    with (
        open_rendezvous(zenoh_settings, "simulated"),
        open_session(zenoh_settings, "simulated", "replay-1") as session,
        open_session(zenoh_settings, "simulated", "viewer") as listener,
    ):
        yield session, listener


@pytest.fixture
def stop():
    """What ends a replay; set by itself in the end, so that no test goes on for ever."""
    event = threading.Event()
    timer = threading.Timer(20, event.set)
    timer.start()
    yield event
    timer.cancel()


def playing(path, **changes):
    values = {
        "log": Log(path),
        "topics": (topics.TRUTH,),
        "span": Span(beginning_ns=START_NS, start_ns=START_NS, end_ns=None),
    }
    return Playing(**(values | changes))


def heard(ring):
    received = []
    while (message := ring.take()) is not None:
        received.append(message)
    return received


def met(session, listener, eventually):
    """A ring of everything on `truth` at a listener whom the session knows, and what the replay is to check."""
    ring, guard = listener.every(topics.TRUTH, 10_000), session.presence()
    eventually(lambda: {"viewer", "rendezvous"} <= guard.alive())
    probe = session.publisher(topics.TRUTH)
    eventually(lambda: (probe.put_bytes(b"probe"), ring.take())[1])
    time.sleep(0.05)
    heard(ring)
    return ring


def test_bytes_numbers_and_spacing_are_those_of_the_recording_and_ages_are_fresh(
    bus, recording, stop, eventually
):
    session, listener = bus
    ring = met(session, listener, eventually)
    before_ns = time.time_ns()
    played = play(playing(recording), session, lambda: None, stop, lambda _: None)
    received = []
    eventually(lambda: received.extend(heard(ring)) or len(received) == len(NUMBERS))

    at_ms = list(itertools.accumulate(GAPS_MS))
    assert [message.sequence for message in received] == list(NUMBERS)
    assert [message.payload for message in received] == [truth(ms) for ms in at_ms]
    times_ns = [message.publish_time_ns for message in received]
    assert all(before_ns < time_ns <= time.time_ns() for time_ns in times_ns)
    assert times_ns == sorted(times_ns)
    # deadlines do not add up their errors: at half of them, at least, the machine was there in time
    errors_ms = [
        (time_ns - times_ns[0]) / MS - (ms - at_ms[0]) for time_ns, ms in zip(times_ns, at_ms, strict=True)
    ]
    assert abs(statistics.median(errors_ms)) < 20
    # the restart of who said it is a restart here too
    epochs = [message.epoch for message in received]
    assert len(set(epochs)) == 2
    assert len(set(epochs[:8])) == 1
    assert played.messages == {"truth": len(NUMBERS)}
    assert played.late_p50_ms <= played.late_p99_ms <= played.late_most_ms


def test_twice_the_speed_takes_half_the_time(bus, recording, stop):
    session, _ = bus
    quiet = (session, lambda: None, stop, lambda _: None)
    slow = play(playing(recording, speed=0.5), *quiet)
    fast = play(playing(recording, speed=4.0), *quiet)
    # 8 to 1, were it not for starting up and for the machine
    assert slow.duration_s > 2 * fast.duration_s
    assert slow.messages == fast.messages


def test_a_loop_goes_on_until_it_is_stopped(bus, recording, stop, eventually):
    session, listener = bus
    ring = met(session, listener, eventually)
    rounds, received = 3, []

    def look(_):
        received.extend(heard(ring))
        if len(received) > rounds * len(NUMBERS):
            stop.set()

    played = play(playing(recording, speed=20.0, loop=True), session, lambda: None, stop, look)
    assert [message.sequence for message in received[: rounds * len(NUMBERS)]] == list(NUMBERS) * rounds
    assert played.messages["truth"] >= rounds * len(NUMBERS)


def test_a_stretch_is_all_that_is_said(bus, recording, stop):
    session, _ = bus
    span = Span(beginning_ns=START_NS, start_ns=START_NS + 150 * MS, end_ns=START_NS + 300 * MS)
    inside = list(Log(recording).messages((topics.TRUTH,), span.start_ns, span.end_ns))
    played = play(playing(recording, span=span, speed=10), session, lambda: None, stop, lambda _: None)
    assert 0 < len(inside) < len(NUMBERS)
    assert played.messages == {"truth": len(inside)}


def test_bytes_of_another_version_are_left_out_and_that_is_said(bus, tmp_path, stop):
    session, _ = bus
    path = tmp_path / "other.mcap"
    with RecordingWriter(path, RecorderSettings()) as writing:
        for topic, kind in ((topics.TRUTH, Truth), (topics.SHAPE, TendonState)):
            writing.write(
                topic.key, kind.protobuf, b"", sequence=0, publish_time_ns=START_NS, log_time_ns=START_NS
            )
    both = playing(path, topics=(topics.TRUTH, topics.SHAPE))
    played = play(both, session, lambda: None, stop, lambda _: None)
    assert played.messages == {"truth": 1}
    assert played.left_out == {"shape": "it holds nodal.TendonState, and nodal.ShapeEstimate in this version"}


def test_nothing_to_say_is_an_error(bus, recording, stop):
    session, _ = bus
    with pytest.raises(ReplayError, match="holds none of these in that stretch: shape"):
        play(
            playing(recording, topics=(topics.SHAPE,)),
            session,
            lambda: None,
            stop,
            lambda _: None,
        )


# ---- the guard


def guard(session, words, *, feed_controller=False):
    return Guard(session.presence(), "simulated", chosen(words), "replay-1", feed_controller=feed_controller)


@pytest.mark.parametrize(
    ("alive", "words", "complaint"),
    [
        ("sensing", ("camera/left", "truth"), "sensing is alive on bench simulated and says camera/left"),
        ("simulation", DEFAULT, "simulation is alive on bench simulated and says truth"),
        ("controller", ("tendon/state",), "controller is alive on bench simulated and says tendon/state"),
        ("controller", ("shape",), "its robot may move by recorded shapes"),
        ("replay-2", ("truth",), r"another replay \(replay-2\) is under way"),
    ],
)
def test_who_must_not_be_alive_is_named(bus, zenoh_settings, alive, words, complaint):
    session, _ = bus
    with (
        open_session(zenoh_settings, "simulated", alive),
        pytest.raises(ReplayError, match=complaint),
    ):
        guard(session, words).meet("here", threading.Event())


@pytest.mark.parametrize(
    ("alive", "words", "feed_controller"),
    [
        ("recorder", ("all",), False),
        ("controller", ("truth", "camera/*"), False),
        ("controller", DEFAULT, True),
        ("sensing", ("tendon/state",), False),
    ],
)
def test_who_may_be_alive_is_left_alone(bus, zenoh_settings, eventually, alive, words, feed_controller):
    session, _ = bus
    with open_session(zenoh_settings, "simulated", alive):
        careful = guard(session, words, feed_controller=feed_controller)
        careful.meet("here", threading.Event())
        assert alive in careful._alive()
        careful.check()


def test_who_comes_later_ends_the_replay(bus, recording, stop, zenoh_settings):
    session, _ = bus
    careful = guard(session, ("sensing", "simulation"))
    careful.meet("here", threading.Event())
    with contextlib.ExitStack() as later:

        def start_sensing(_):
            if not later._exit_callbacks:
                later.enter_context(open_session(zenoh_settings, "simulated", "sensing"))

        with pytest.raises(ReplayError, match="sensing is alive"):
            play(playing(recording, loop=True), session, careful.check, stop, start_sensing)


def test_without_a_rendezvous_nobody_hears_and_that_is_said(zenoh_settings, monkeypatch):
    monkeypatch.setattr("nodal.replay.live.guard.MEET_WITHIN_S", 0.2)
    with (
        open_session(zenoh_settings, "simulated", "replay-1") as session,
        pytest.raises(ReplayError, match="no rendezvous of bench simulated answers at there"),
    ):
        guard(session, DEFAULT).meet("there", threading.Event())


# ---- the command


@pytest.fixture
def bench_file(tmp_path, zenoh_settings):
    """The simulated bench, with its bus at a free port."""
    table = read_table(bench_path("simulated"))
    table["calibration"] = load_bench("simulated").settings.calibration
    table["zenoh"] = {"rendezvous": zenoh_settings.rendezvous}
    path = tmp_path / "bench.toml"
    path.write_text(written(table), encoding="utf-8")
    return path


def test_a_signal_ends_the_command_in_good_order(recording, bench_file, zenoh_settings, eventually):
    words = ["replay", str(recording), "--live", "--config", str(bench_file), "--topics", "truth"]
    with (
        open_rendezvous(zenoh_settings, "simulated"),
        open_session(zenoh_settings, "simulated", "viewer") as listener,
        subprocess.Popen(
            [sys.executable, "-m", "nodal", *words, "--loop", "--speed", "2"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as child,
    ):
        ring = listener.every(topics.TRUTH, 10_000)
        try:
            eventually(lambda: child.poll() is not None or len(heard(ring)) > 0)
            child.send_signal(signal.SIGINT)
            out, err = child.communicate(timeout=15)
        finally:
            child.kill()
    assert (child.returncode, err) == (0, "")
    assert "messages of 1 topics" in out


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--topics", "all", "--loop"], "--topics, --loop: means something only beside --live"),
        (["--live", "--jobs", "2"], "--jobs: means something only without --live"),
        (["--live", "--topics", "shapes"], "--topics 'shapes': neither a key that is recorded"),
        (["b.mcap", "--live"], "--live replays one recording at a time; there are 2"),
    ],
)
def test_what_does_not_go_together_is_refused(recording, words, complaint, capsys):
    assert main(["replay", str(recording), *words]) == 2
    assert complaint in capsys.readouterr().err


@pytest.mark.parametrize("speed", ["0", "-1", "nan", "inf", "fast"])
def test_an_impossible_speed_is_refused(speed, capsys):
    parser = argparse.ArgumentParser()
    add_live_arguments(parser)
    with pytest.raises(SystemExit):
        parser.parse_args(["--live", "--speed", speed])
    assert "is not a speed" in capsys.readouterr().err
