"""New recordings made of a recording: the whole of what can be read, or a stretch of it that stands alone."""

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from nodal.errors import CommandError
from nodal.exports.output import new_file
from nodal.log.lines import utc
from nodal.report.loading import lost_in
from recordings import Log
from recordings.backlog import SELDOM
from recordings.copying import Copy
from recordings.reader import topic_of
from recordings.streams import Stream

OWN_NOTES = ("PART", "SUMMARY")
"""Metadata that hold of one file only."""

COMPRESSIONS = ("lz4", "zstd")


@dataclass(frozen=True, kw_only=True)
class Derived:
    """A recording that was written: its messages by topic, the log times between which they lie, and how many of the
    first of them are older ones repeated.
    """

    path: Path
    messages: Counter[str]
    span_ns: tuple[int, int]
    repeated: int


def recovered(log: Log, out: Path) -> Derived:
    """Write everything that can be read into one whole file; raises CommandError, RecordingError."""
    part = log.metadata("PART").get(log.parts[0], {})
    because = f"recovered from {', '.join(file.name for file in log.parts)}"
    with _copy(log, out, because, int(part.get("repeated", 0))) as copy:
        copy.write(entry for _, entry in log.entries())
        if copy.span_ns is None:
            raise CommandError(f"{log.path}: no message in it can be read")
        damage = {f"damage/{number}": str(damage) for number, damage in enumerate(log.damage, 1)}
        copy.describe("RECOVERED", {"from": ", ".join(str(file) for file in log.parts), **damage})
        ended = log.metadata("SUMMARY").get(log.parts[-1], {}).get("ended_because", "it was cut off")
        copy.summarise(lost_in(log.metadata("SUMMARY").values()), f"{ended}; {because}")
    return Derived(path=out, messages=copy.messages, span_ns=copy.span_ns, repeated=0)


def cut(log: Log, start_ns: int, end_ns: int, out: Path) -> Derived:
    """Write what was logged from `start_ns` on and before `end_ns`, behind the newest earlier message of each topic that is
    said seldom, repeated as the recorder does it at the beginning of a part. Raises CommandError, RecordingError.
    """
    newest = {entry.stream.topic: entry for _, entry in log.entries(_is_said_seldom, None, start_ns)}
    because = f"cut out of {log.path.name}, from {utc(start_ns)} to {utc(end_ns)}"
    with _copy(log, out, because, len(newest)) as copy:
        copy.write(newest.values(), start_ns)
        copy.write(entry for _, entry in log.entries(None, start_ns, end_ns))
        if copy.span_ns is None or copy.messages.total() == len(newest):
            raise CommandError(f"{log.path}: nothing was recorded between {utc(start_ns)} and {utc(end_ns)}")
        copy.describe("CUT", {"from": str(log.path), "start_ns": str(start_ns), "end_ns": str(end_ns)})
        copy.summarise({}, because)
    return Derived(path=out, messages=copy.messages, span_ns=copy.span_ns, repeated=len(newest))


@contextmanager
def _copy(log: Log, out: Path, because: str, repeated: int) -> Iterator[Copy]:
    """A new recording with the attachments and metadata of another; it has its name only once it is whole."""
    begin_ns = (log.span_ns or (0, 0))[0]
    with new_file(out) as draft, Copy(draft, compressed=_is_compressed(log)) as copy:
        copy.attach(log.attachments, begin_ns)
        for name, facts in _notes(log).items():
            copy.describe(name, facts)
        copy.describe(
            "PART",
            {"number": "1", "recording": out.name, "because": because, "repeated": str(repeated)},
        )
        yield copy


def _notes(log: Log) -> Mapping[str, Mapping[str, str]]:
    notes: dict[str, Mapping[str, str]] = {}
    for file in log.files:
        notes |= {name: facts for name, facts in file.metadata().items() if name not in OWN_NOTES}
    return notes


def _is_compressed(log: Log) -> bool:
    return any(file.compression in COMPRESSIONS for file in log.files)


def _is_said_seldom(stream: Stream) -> bool:
    topic = topic_of(stream.topic)
    return topic is not None and topic.key in SELDOM
