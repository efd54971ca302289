"""`nodal replay LOG --live`: recorded bytes go back onto the bus, when they are due and as if they were new.

Payloads and sequence numbers are those of the recording, publish times those of now: a receiver judges ages as it did
then. What is late goes out at once, and nothing is left out.
"""

import argparse
import dataclasses
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from threading import Event

import msgspec

from messaging.message import Message
from messaging.session import Publisher, Session, open_session
from messaging.topics import Topic
from nodal.bench_file import load_bench, recorded_bench
from nodal.bench_settings import BenchSettings
from nodal.errors import ReplayError
from nodal.log.spans import Span, span_of
from nodal.replay.live.guard import REPLAY, Guard
from nodal.replay.live.order import read_ahead, timeline
from nodal.replay.live.pace import Pace
from nodal.replay.live.topics import DEFAULT, chosen
from nodal.running import stop_on_signals
from recordings.log import Log
from recordings.reader import Recorded, topic_of

TELL_S = 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Playing:
    """What is played: topics of a stretch of a log, how many times as fast, and whether it begins again at the end."""

    log: Log
    topics: Sequence[Topic]
    span: Span
    speed: float = 1.0
    loop: bool = False

    def rounds(self) -> Iterator[Iterator[Recorded]]:
        """The publications, read as they are needed."""
        for _ in repeat(None) if self.loop else range(1):
            yield self.log.messages(self.topics, self.span.start_ns, self.span.end_ns)


class Played(msgspec.Struct, frozen=True, kw_only=True):
    """What was said: publications by topic, how long that took, and how late they were."""

    messages: dict[str, int]
    left_out: dict[str, str]
    """Topics of another version, whose bytes would mislead whoever hears them, with the reason."""
    duration_s: float
    late_p50_ms: float
    late_p99_ms: float
    late_most_ms: float

    def __str__(self) -> str:
        """One line."""
        return (
            f"{sum(self.messages.values())} messages of {len(self.messages)} topics in {self.duration_s:.1f} s, "
            f"late by {self.late_p50_ms:.2f} ms (p50), {self.late_p99_ms:.2f} ms (p99), {self.late_most_ms:.2f} ms (most)"
        )


def replay_live(arguments: argparse.Namespace) -> int:
    """Replay one log onto a bench's bus until it ends or a signal comes; raises NodalError."""
    if len(arguments.logs) > 1:
        raise ReplayError(f"--live replays one recording at a time; there are {len(arguments.logs)}")
    log = Log(arguments.logs[0])
    playing = Playing(
        log=log,
        topics=chosen(arguments.topics or DEFAULT),
        span=span_of(log, arguments),
        speed=arguments.speed or 1.0,
        loop=arguments.loop,
    )
    bench = _bench(arguments.config, log)
    stop = stop_on_signals()
    sys.setswitchinterval(0.0002)  # the thread that reads ahead then holds the interpreter for 0.2 ms, not 5
    name = f"{REPLAY}{os.getpid()}"
    with open_session(bench.zenoh, bench.name, name) as session:
        guard = Guard(
            session.presence(), bench.name, playing.topics, name, feed_controller=arguments.feed_controller
        )
        guard.meet(bench.zenoh.rendezvous, stop)
        played = play(playing, session, guard.check, stop, _Telling() if sys.stderr.isatty() else _silent)
    for key, reason in played.left_out.items():
        print(f"nodal: left out: {key}: {reason}", file=sys.stderr)
    for damage in dict.fromkeys(map(str, log.damage)):
        print(f"nodal: damaged: {damage}", file=sys.stderr)
    print(msgspec.json.format(msgspec.json.encode(played)).decode() if arguments.json else played)
    return 0


def play(
    playing: Playing,
    session: Session,
    check: Callable[[], None],
    stop: Event,
    tell: Callable[[float], None],
) -> Played:
    """Say everything when it is due, until it is over or `stop` is set.

    `check` comes right before every publication and raises what ends the replay; `tell` gets the seconds since the first.
    Raises ReplayError when there is nothing to say, RecordingError.
    """
    voices, said, start_s = _Voices(session), Counter[str](), time.monotonic()
    with ThreadPoolExecutor(1, "reads ahead") as executor:
        ahead = read_ahead(timeline(playing.rounds()), executor)
        pace = None
        for due_ns, recorded in ahead:
            pace = pace or Pace(playing.speed, stop)
            while not pace.reached(due_ns) and not stop.is_set():
                check()
            if stop.is_set():
                break
            check()
            if voices.say(recorded):
                said[recorded.topic] += 1
            tell(due_ns / 1e9)
    if pace is None:
        keys = ", ".join(topic.key for topic in playing.topics)
        raise ReplayError(f"{playing.log.path} holds none of these in that stretch: {keys}")
    return Played(
        messages=dict(sorted(said.items())),
        left_out=voices.left_out,
        duration_s=time.monotonic() - start_s,
        late_p50_ms=pace.lateness.quantile_ms(0.5),
        late_p99_ms=pace.lateness.quantile_ms(0.99),
        late_most_ms=pace.lateness.quantile_ms(1.0),
    )


class _Voices:
    """A publisher for each key, and another one whenever its numbers begin anew, as after a restart of who said it."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._publishers: dict[str, tuple[Publisher[Message], int]] = {}
        self.left_out: dict[str, str] = {}

    def say(self, recorded: Recorded) -> bool:
        """Send it with its own number; False when it is left out."""
        publisher, last = self._publishers.get(recorded.topic, (None, -1))
        if publisher is None or recorded.sequence <= last:
            if why_not := _misfit(recorded):
                self.left_out[recorded.topic] = why_not
                return False
            publisher = self._session.publisher(_topic(recorded.topic))
        number = publisher.put_bytes(recorded.payload, recorded.sequence)
        self._publishers[recorded.topic] = publisher, number
        return True


def _misfit(recorded: Recorded) -> str:
    expected = _topic(recorded.topic).type.protobuf.DESCRIPTOR.full_name
    return (
        "" if recorded.schema == expected else f"it holds {recorded.schema}, and {expected} in this version"
    )


def _topic(key: str) -> Topic:
    topic = topic_of(key)
    if topic is None:
        raise ReplayError(f"this version knows no topic {key!r}")
    return dataclasses.replace(topic, key=key)


def _bench(config: str | None, log: Log) -> BenchSettings:
    bench = recorded_bench(log.path, log.attachments, {}) if config is None else load_bench(config)
    return bench.settings


class _Telling:
    """A line on a terminal, drawn anew every second."""

    def __init__(self) -> None:
        self._next_s = 0.0

    def __call__(self, over_s: float) -> None:
        if (now_s := time.monotonic()) >= self._next_s:
            self._next_s = now_s + TELL_S
            print(f"\r{over_s:8.1f} s", end="\r", file=sys.stderr, flush=True)


def _silent(_: float) -> None:
    pass
