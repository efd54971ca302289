"""What happened in a run, as its user names it: fault, hold, flag:tip_unseen, state:tracking, target:circle ..."""

import argparse
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from messaging import topics
from messaging.control import State
from messaging.errors import CodecError
from messaging.message import parse
from messaging.topics import Topic
from nodal.errors import CommandError
from nodal.report.traffic import ONE_VOICE
from recordings import Log

WARNING = 3
"""Level of foxglove.Log from which on a line warns or worse."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Events that messages of one topic tell of. `names` are those that hold in a message (protobuf); "" has no name.

    An event that `lasts` happens where its name begins to hold; any other in each message.
    """

    topic: Topic
    names: Callable[[Any], Iterable[str]]
    lasts: bool


def _only_if(holds: Callable[[Any], bool]) -> Callable[[Any], Iterable[str]]:
    return lambda said: [""] if holds(said) else []


KINDS = {
    "fault": Kind(
        topic=topics.CONTROLLER_STATE, names=_only_if(lambda said: said.state == State.FAULT), lasts=True
    ),
    "hold": Kind(
        topic=topics.CONTROLLER_STATE,
        names=_only_if(lambda said: said.state == State.HOLD and "operator" not in said.reason),
        lasts=True,
    ),
    "state": Kind(topic=topics.CONTROLLER_STATE, names=lambda said: [said.state], lasts=True),
    "target": Kind(topic=topics.TARGET, names=lambda said: [said.name], lasts=False),
    "asked": Kind(topic=topics.ASKED, names=lambda said: [said.service], lasts=False),
    "flag": Kind(topic=topics.SHAPE, names=lambda said: said.flags, lasts=True),
    "refusal": Kind(topic=topics.SHAPE, names=_only_if(lambda said: bool(said.refusal)), lasts=True),
    "warning": Kind(
        topic=topics.LOG, names=lambda said: [said.name] if said.level >= WARNING else [], lasts=False
    ),
}
RESTART = "restart"
ALLOWED = (
    f"{', '.join(KINDS)}, {RESTART}; or one of them by name: state:NAME, target:NAME, asked:SERVICE, flag:NAME, "
    "warning:PROCESS, restart:PROCESS"
)


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Events of one kind: of any name, or of this one. `text` is how they were asked for."""

    text: str
    kind: str
    name: str


def event(text: str) -> Wanted:
    """What `fault` or `state:tracking` asks for; raises ArgumentTypeError."""
    kind, _, name = text.partition(":")
    if kind not in (*KINDS, RESTART):
        raise argparse.ArgumentTypeError(f"{text!r} is no event; allowed are {ALLOWED}")
    return Wanted(text=text, kind=kind, name=name)


def times_of(log: Log, wanted: Wanted) -> list[int]:
    """When it happened in this recording (log times, Unix ns); raises CommandError when it did not, naming what did."""
    found = happened(log, wanted.kind)
    times_ns = [time_ns for time_ns, name in found if wanted.name in ("", name)]
    if not times_ns:
        raise CommandError(f"{log.path}: {wanted.text} does not occur; {_occurring(log)}")
    # one message may tell of several, by different names
    return sorted(set(times_ns))


def happened(log: Log, word: str) -> Iterator[tuple[int, str]]:
    """When events of this kind happened (log times, Unix ns), and their names; what cannot be read tells nothing."""
    if word == RESTART:
        yield from _restarts(log)
        return
    kind = KINDS[word]
    before: set[str] = set()
    for recorded in log.messages([kind.topic]):
        try:
            names = set(kind.names(parse(kind.topic.type.protobuf, recorded.payload)))
        except CodecError:
            continue
        for name in sorted(names - before if kind.lasts else names):
            yield recorded.log_time_ns, name
        before = names


def _restarts(log: Log) -> Iterator[tuple[int, str]]:
    newest: dict[str, int] = {}
    said_by = {topic.key: topic.said_by for topic in ONE_VOICE}
    for recorded in log.messages(ONE_VOICE):
        if recorded.sequence < newest.get(recorded.topic, 0):
            yield recorded.log_time_ns, said_by[recorded.topic]
        newest[recorded.topic] = recorded.sequence


def _occurring(log: Log) -> str:
    counts = Counter(
        f"{word}:{name}" if name else word for word in (*KINDS, RESTART) for _, name in happened(log, word)
    )
    told = ", ".join(name if count == 1 else f"{name} ({count} times)" for name, count in counts.items())
    return f"what does: {told}" if told else "no event does"
