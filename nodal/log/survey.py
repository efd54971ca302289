"""One pass through a recording for what `nodal log info` and `check` say. Pictures are not decoded."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from messaging import topics
from messaging.errors import CodecError, InvalidMessageError
from messaging.history import Asked
from messaging.message import parse
from messaging.topics import Topic
from nodal.bench_file import BENCH_ATTACHMENT
from nodal.errors import BenchFileError
from nodal.log.traffic import Heard, Traffic
from nodal.toml_file import table_in
from recordings import Log
from recordings.file_reader import Entry
from recordings.output import in_use
from recordings.parts import GOES_ON_IN
from recordings.reader import topic_of
from recordings.source import finished

CONTROLLER_TOPICS = (topics.TENDON_COMMAND, topics.TENDON_STATE, topics.CONTROLLER_STATE)
CAMERA_TOPICS = (
    topics.CAMERA,
    topics.SHAPE,
    topics.CENTRELINE,
    topics.NODAL_POINTS,
    topics.DESIRED_POINTS,
    topics.TRUTH,
)


@dataclass(kw_only=True)
class Spell:
    """A stretch of one state of the controller, for one target. Unix ns; the reason is that of its first cycle."""

    state: str
    target: str
    reason: str
    begin_ns: int
    end_ns: int


@dataclass(kw_only=True)
class Part:
    """One file. `ended` says why the recorder ended it; empty when it was cut off."""

    path: Path
    size_bytes: int
    span_ns: tuple[int, int] | None
    ended: str
    in_use: bool


@dataclass(kw_only=True)
class Survey:
    """What a recording holds. Times are Unix ns, ages ns."""

    log: Log
    parts: list[Part]
    heard: dict[str, Heard] = field(default_factory=dict)
    capture_to_publish_ns: list[int] = field(default_factory=list)
    capture_to_command_ns: list[int] = field(default_factory=list)
    flagged: Counter[str] = field(default_factory=Counter)
    refused: int = 0
    suspicious: int = 0
    """Shapes with one flag or more."""
    spells: list[Spell] = field(default_factory=list)
    targets: list[tuple[int, str]] = field(default_factory=list)
    asked: list[Asked] = field(default_factory=list)
    unreadable: Counter[str] = field(default_factory=Counter)
    foreign: dict[str, str] = field(default_factory=dict)
    """Topics that this version does not know, and what they hold."""

    @property
    def begin_ns(self) -> int:
        """The first log time; 0 without messages."""
        return (self.log.span_ns or (0, 0))[0]

    @property
    def end_ns(self) -> int:
        """The last log time; 0 without messages."""
        return (self.log.span_ns or (0, 0))[1]

    def second(self, time_ns: int) -> float:
        """Seconds since the recording began."""
        return (time_ns - self.begin_ns) / 1e9

    @cached_property
    def bench(self) -> Mapping[str, Any]:
        """The attached bench file; empty when there is none that can be read."""
        try:
            return table_in(self.log.attachments.get(BENCH_ATTACHMENT, b""), BENCH_ATTACHMENT)
        except BenchFileError:
            return {}

    @cached_property
    def traffic(self) -> dict[str, Traffic]:
        """Each topic's, by key."""
        return {key: Traffic(heard, self.expected_hz(key)) for key, heard in sorted(self.heard.items())}

    @cached_property
    def lost(self) -> dict[str, int]:
        """What the recorder counted as lost, by topic; parts that were cut off hold no count."""
        lost: Counter[str] = Counter()
        for summary in self.log.metadata("SUMMARY").values():
            for key, count in summary.items():
                if key.startswith("lost/") and count.isdecimal():
                    lost[key.removeprefix("lost/")] += int(count)
        return dict(lost)

    @cached_property
    def versions(self) -> dict[str, str]:
        """Of the packages that recorded it, by the last part that says so."""
        versions: dict[str, str] = {}
        for noted in self.log.metadata("VERSIONS").values():
            versions |= noted
        return versions

    def missing(self, key: str) -> int | None:
        """How many numbers a topic's only publisher left out; None for a topic whose publishers are many or unknown."""
        topic = topic_of(key)
        return None if topic is None or topic.said_by == "all" else self.traffic[key].missing

    def expected_hz(self, key: str) -> float | None:
        """By the attached bench file where that says it, by the table of topics else."""
        topic = topic_of(key)
        if topic is None or topic.rate_hz is None:
            return None
        said = None
        if topic in CONTROLLER_TOPICS:
            said = self._setting("controller", "rate_hz")
        elif topic in CAMERA_TOPICS:
            said = self._setting("simulation", "cameras", "sensor", "rate_hz")
        return float(said) if isinstance(said, int | float) else topic.rate_hz

    def _setting(self, *keys: str) -> object:
        value: object = self.bench
        for key in keys:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    def _take(self, entry: Entry) -> None:
        stream = entry.stream
        if stream.topic not in self.heard:
            self.heard[stream.topic] = Heard(schema=stream.schema)
        self.heard[stream.topic].hear(
            entry.log_time_ns, entry.publish_time_ns, entry.sequence, len(entry.payload)
        )
        topic = topic_of(stream.topic)
        if topic is None or topic.type.protobuf.DESCRIPTOR.full_name != stream.schema:
            self.foreign[stream.topic] = (
                f"{stream.schema or 'no schema'} ({stream.encoding or 'no encoding'})"
            )
            return
        try:
            self._look_into(topic, entry)
        except (CodecError, InvalidMessageError):
            self.unreadable[stream.topic] += 1

    def _look_into(self, topic: Topic, entry: Entry) -> None:
        # the protobuf message alone: checking every array of every message would take several times as long
        if topic == topics.SHAPE:
            shape = parse(topic.type.protobuf, entry.payload)
            self.capture_to_publish_ns.append(shape.capture_to_publish_ns)
            self.refused += bool(shape.refusal)
            self.suspicious += bool(shape.flags)
            self.flagged.update(shape.flags)
        elif topic == topics.TENDON_COMMAND:
            command = parse(topic.type.protobuf, entry.payload)
            # a command without a shape behind it is of no age
            if command.capture_to_command_ns > 0:
                self.capture_to_command_ns.append(command.capture_to_command_ns)
        elif topic == topics.CONTROLLER_STATE:
            self._spell(parse(topic.type.protobuf, entry.payload), entry.log_time_ns)
        elif topic == topics.TARGET:
            self.targets.append((entry.log_time_ns, parse(topic.type.protobuf, entry.payload).name))
        elif topic == topics.ASKED:
            self.asked.append(Asked.from_bytes(entry.payload))

    def _spell(self, state: Any, time_ns: int) -> None:
        last = self.spells[-1] if self.spells else None
        if last is not None:
            last.end_ns = time_ns
        if last is None or (last.state, last.target) != (state.state, state.target_name):
            self.spells.append(
                Spell(
                    state=state.state,
                    target=state.target_name,
                    reason=state.reason,
                    begin_ns=time_ns,
                    end_ns=time_ns,
                )
            )


def survey(log: Log) -> Survey:
    """Read the whole recording; raises RecordingError."""
    found = Survey(log=log, parts=[])
    for _, entry in log.entries():
        found._take(entry)  # noqa: SLF001  its own module
    summaries = log.metadata("SUMMARY")
    for file in log.files:
        summary = summaries.get(file.path)
        found.parts.append(
            Part(
                path=file.path,
                size_bytes=file.path.stat().st_size,
                span_ns=file.span_ns,
                ended=_ending(summary, finished(file.path)),
                in_use=in_use(file.path),
            )
        )
    return found


def _ending(summary: Mapping[str, str] | None, whole: bool) -> str:
    if summary is None:
        return "it was finished" if whole else ""
    if GOES_ON_IN in summary:
        return f"it goes on in {summary[GOES_ON_IN]}"
    return summary.get("ended_because", "it was finished")
