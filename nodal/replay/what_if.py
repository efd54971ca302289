"""A new recording of what would have been: the old one's pictures, servos and requests, with estimates and commands made anew."""

import time
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import count
from pathlib import Path

import msgspec

from messaging import topics
from messaging.control import ControllerState
from messaging.errors import NodalError
from messaging.history import Asked, Memory
from messaging.message import Message
from messaging.shape import ShapeEstimate
from messaging.topics import Topic
from messaging.views import CentrelineView, DesiredPointsView, NodalPointsView, TargetPathView
from nodal.bench_file import Bench
from nodal.errors import ReplayError
from nodal.replay import controlling, sensing
from nodal.replay.comparison import Comparison, compared
from nodal.replay.controlling import Cycle
from nodal.replay.cycles import REQUESTS, ControlPart
from nodal.replay.frame_sets import FrameSetRecord, never_estimated
from nodal.replay.recorded import bench_of
from nodal.replay.script import whole
from nodal.replay.typed import read
from nodal.replay.verification import Verdict
from nodal.toml_file import Table
from recordings.log import Log
from recordings.part import versions
from recordings.reader import Recorded, topic_of
from recordings.writer import RecordingWriter

MADE_ANEW = {
    topic.key
    for topic in (
        topics.SHAPE,
        topics.CENTRELINE,
        topics.NODAL_POINTS,
        topics.SENSING_MEMORY,
        topics.TARGET,
        topics.TARGET_PATH,
        topics.TENDON_COMMAND,
        topics.CONTROLLER_STATE,
        topics.DESIRED_POINTS,
        topics.CONTROLLER_MEMORY,
    )
}
"""Topics of which nothing is kept."""
MEMORY_PERIOD_NS = 1_000_000_000
NOTE = "REPLAY"
"""Name of the metadata that says what a recording is a replay of."""


def write_what_if(path: Path, changes: Table, out: Path, law: Path | None) -> Verdict:
    """Replay the log at `path` with other settings into `out`; the verdict says how that differs from what was logged.

    Raises ReplayError, whatever else went wrong, since others would not find their way back from a worker.
    """
    try:
        return _written(path, changes, out, law)
    except NodalError as error:
        raise ReplayError(str(error)) from None


def _written(path: Path, changes: Table, out: Path, law: Path | None) -> Verdict:
    started_s = time.monotonic()
    log = Log(path)
    bench = bench_of(log, changes, law)
    sensed, controlled = whole(log)
    if not sensed.sets:
        sensed = replace(sensed, sets=never_estimated(log, tuple(bench.settings.cameras)))
    if not sensed.sets and not controlled.states:
        raise ReplayError(
            f"{path}: it holds neither frame sets nor cycles of the controller; there is nothing to replay"
        )
    points = bench.settings.sensing.points if "nodal_points" in changes.get("sensing", {}) else None
    estimates = {
        record.capture_time_ns: (record, estimate, memory)
        for record, estimate, memory in sensing.imagine(sensed, bench, points)
    }
    found = Comparison()
    with RecordingWriter(out, bench.settings.recorder) as recording:
        # where other nodal points are reported, those that an operator asked for were never asked for
        services = {*REQUESTS, *({topics.SENSING_NODES.key} if points else ())}
        imagined = _Imagined(recording, bench, controlled, estimates, services)
        first = next(log.messages(), None)
        began_ns = first.log_time_ns if first else 0
        for name, data in bench.attachments().items():
            recording.attach(name, data, began_ns)
        recording.describe("VERSIONS", versions())
        recording.describe(NOTE, {"of": path.name, "nodal": version("nodal"), "set": _text(changes)})
        last_ns = began_ns
        for recorded in log.messages():
            found += imagined.follow(recorded)
            last_ns = recorded.log_time_ns
        duration_s = (last_ns - began_ns) / 1e9
        messages = {f"messages/{key}": str(number) for key, number in recording.messages.items()}
        recording.describe("SUMMARY", {**messages, "duration_s": f"{duration_s:.3f}"})
    return Verdict(
        log=str(path),
        out=str(out),
        span_s=duration_s,
        took_s=time.monotonic() - started_s,
        comparison=found,
        damage=[str(damage) for damage in log.damage],
    )


class _Imagined:
    """Writes the old recording's messages one after another, and behind each what follows from it now."""

    def __init__(
        self,
        recording: RecordingWriter,
        bench: Bench,
        controlled: ControlPart,
        estimates: Mapping[int, tuple[FrameSetRecord, ShapeEstimate, bytes]],
        services: Collection[str],
    ) -> None:
        """What was asked of these services is not kept; what was asked of the controller is answered anew."""
        self._recording = recording
        self._services = services
        shapes = {capture_ns: estimate for capture_ns, (_, estimate, _) in estimates.items()}
        self._asked = controlled.asked
        self._memories = controlled.memories
        self._cycles = controlling.imagine(controlled, bench, shapes)
        self._cycle = next(self._cycles, None)
        self._first_cycle_ns = 0 if self._cycle is None else self._cycle.account.controller.time_ns
        self._sets = iter(estimates.values())
        self._set = next(self._sets, None)
        self._memory_due_ns = 0
        self._numbers: dict[str, Iterator[int]] = {}

    def follow(self, recorded: Recorded) -> Comparison:
        """Write what remains of this message, and what is made anew behind it; says how that differs."""
        found = Comparison()
        topic = topic_of(recorded.topic)
        if topic is not None and not self._is_made_anew(recorded):
            self._recording.write(
                recorded.topic,
                topic.type.protobuf,
                recorded.payload,
                sequence=recorded.sequence,
                publish_time_ns=recorded.publish_time_ns,
                log_time_ns=recorded.log_time_ns,
            )
        while self._set is not None and self._set[0].log_time_ns <= recorded.log_time_ns:
            found += self._say_estimate(*self._set, recorded.log_time_ns)
            self._set = next(self._sets, None)
        if self._cycle is not None and _is_same(self._cycle.recorded, recorded):
            found += self._say_cycle(self._cycle)
            self._cycle = next(self._cycles, None)
        return found

    def _is_made_anew(self, recorded: Recorded) -> bool:
        if recorded.topic == topics.ASKED.key:
            return read(recorded, Asked).service in self._services
        if recorded.topic == topics.CONTROLLER_MEMORY.key:
            # the one that the first cycle begins with is kept
            return read(recorded, Memory).time_ns >= self._first_cycle_ns
        return recorded.topic in MADE_ANEW

    def _say_estimate(
        self, record: FrameSetRecord, estimate: ShapeEstimate, memory: bytes, log_time_ns: int
    ) -> Comparison:
        times = _Times(publish_ns=record.publish_time_ns, log_ns=log_time_ns)
        self._say(topics.SHAPE, estimate, times, record.publication)
        if not estimate.refusal:
            self._say(topics.CENTRELINE, CentrelineView.of(estimate), times)
            self._say(topics.NODAL_POINTS, NodalPointsView.of(estimate), times)
        if estimate.capture_time_ns >= self._memory_due_ns:
            self._memory_due_ns = estimate.capture_time_ns + MEMORY_PERIOD_NS
            remembered = Memory(
                time_ns=estimate.capture_time_ns, content=memory, publication=record.publication
            )
            self._say(topics.SENSING_MEMORY, remembered, times)
        if record.estimate is None:
            return Comparison()
        return compared(topics.SHAPE.key, estimate.capture_time_ns, record.estimate, estimate)

    def _say_cycle(self, cycle: Cycle) -> Comparison:
        recorded, account, controller = cycle.recorded, cycle.account, cycle.account.controller
        times = _Times(publish_ns=recorded.publish_time_ns, log_ns=recorded.log_time_ns)
        if account.command is not None:
            self._say(topics.TENDON_COMMAND, account.command, times)
        self._say(topics.CONTROLLER_STATE, controller, times, recorded.sequence)
        if cycle.outputs.accepted is not None:
            self._say(topics.TARGET, cycle.outputs.accepted, times)
            path = TargetPathView.of(cycle.outputs.accepted, controller.time_ns)
            self._say(topics.TARGET_PATH, path, times)
        if account.fresh and controller.node_names:
            self._say(topics.DESIRED_POINTS, DesiredPointsView.of(controller), times)
        asked = self._asked.get(controller.time_ns, ())
        for question, reply in zip(asked, cycle.outputs.replies, strict=True):
            answered = Asked.of(question.service, question.request, reply, question.time_ns)
            self._say(topics.ASKED, answered, times)
        if controller.time_ns in self._memories:
            remembered = Memory(
                time_ns=controller.time_ns,
                content=cycle.after.to_bytes(),
                publication=recorded.sequence,
            )
            self._say(topics.CONTROLLER_MEMORY, remembered, times)
        return compared(
            topics.CONTROLLER_STATE.key, controller.time_ns, read(recorded, ControllerState), controller
        )

    def _say(self, topic: Topic, message: Message, times: "_Times", number: int | None = None) -> None:
        if number is None:
            number = next(self._numbers.setdefault(topic.key, count()))
        self._recording.write(
            topic.key,
            type(message).protobuf,
            message.to_bytes(),
            sequence=number,
            publish_time_ns=times.publish_ns,
            log_time_ns=times.log_ns,
        )


@dataclass(frozen=True, kw_only=True)
class _Times:
    publish_ns: int
    log_ns: int


def _is_same(one: Recorded, other: Recorded) -> bool:
    return (one.topic, one.sequence, one.log_time_ns) == (other.topic, other.sequence, other.log_time_ns)


def _text(changes: Table) -> str:
    return msgspec.json.encode(changes).decode()
