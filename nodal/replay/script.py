"""What a log says that sensing and the controller did, whole or cut into stretches that can be replayed side by side."""

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from messaging import topics
from messaging.control import ControllerState, TendonCommand, TendonState
from messaging.history import Asked, Memory
from messaging.shape import NodalPoints
from nodal.replay.cycles import REQUESTS, ControlPart
from nodal.replay.frame_sets import FrameSetRecord
from nodal.replay.sensing import SensingPart
from nodal.replay.typed import read, time_ns_in
from recordings.log import Log
from recordings.reader import Recorded

STRETCH_NS = 5_000_000_000
"""How long a stretch is at least: it begins with a memory, and what it needs is read again around its ends."""
SEEN_WITHIN_NS = 10_000_000_000
"""A cycle sees no shape older than this."""


@dataclass
class _Heard:
    """The small messages of a log, by what they are needed for."""

    sets: list[FrameSetRecord] = field(default_factory=list)
    sensing_memories: list[Memory] = field(default_factory=list)
    named: list[tuple[int, NodalPoints]] = field(default_factory=list)
    states: list[Recorded] = field(default_factory=list)
    tendons: dict[int, Recorded] = field(default_factory=dict)
    commands: dict[int, Recorded] = field(default_factory=dict)
    asked: dict[int, list[Asked]] = field(default_factory=lambda: defaultdict(list))
    shapes: dict[int, Recorded] = field(default_factory=dict)
    control_memories: list[Memory] = field(default_factory=list)

    def hear(self, recorded: Recorded) -> None:
        match recorded.topic:
            case topics.SHAPE.key:
                self.sets.append(record := FrameSetRecord.of(recorded))
                self.shapes[record.capture_time_ns] = recorded
            case topics.SENSING_MEMORY.key:
                self.sensing_memories.append(read(recorded, Memory))
            case topics.CONTROLLER_STATE.key:
                self.states.append(recorded)
            case topics.TENDON_STATE.key:
                self.tendons[time_ns_in(recorded, TendonState)] = recorded
            case topics.TENDON_COMMAND.key:
                self.commands[time_ns_in(recorded, TendonCommand)] = recorded
            case topics.CONTROLLER_MEMORY.key:
                self.control_memories.append(read(recorded, Memory))
            case topics.ASKED.key:
                self._hear_asked(recorded)

    def _hear_asked(self, recorded: Recorded) -> None:
        asked = read(recorded, Asked)
        if asked.service in REQUESTS:
            self.asked[asked.time_ns].append(asked)
        elif asked.service == topics.SENSING_NODES.key and asked.accepted:
            self.named.append((recorded.publish_time_ns, NodalPoints.from_bytes(asked.request)))


HEARD = (
    topics.SHAPE,
    topics.SENSING_MEMORY,
    topics.CONTROLLER_STATE,
    topics.TENDON_STATE,
    topics.TENDON_COMMAND,
    topics.CONTROLLER_MEMORY,
    topics.ASKED,
)


def whole(log: Log) -> tuple[SensingPart, ControlPart]:
    """All that a log says; raises RecordingError, CodecError or InvalidMessageError for what is not what it claims to be."""
    heard = _Heard()
    for recorded in log.messages(HEARD):
        heard.hear(recorded)
    sensing = SensingPart(
        path=log.path,
        sets=heard.sets,
        memories={memory.time_ns: memory for memory in heard.sensing_memories},
        named=heard.named,
        before=_before([record.publication for record in heard.sets], heard.sensing_memories),
    )
    control = ControlPart(
        states=heard.states,
        tendons=heard.tendons,
        commands=heard.commands,
        asked=dict(heard.asked),
        shapes=heard.shapes,
        memories={memory.time_ns: memory for memory in heard.control_memories},
        before=_before([recorded.sequence for recorded in heard.states], heard.control_memories),
    )
    return sensing, control


def sensing_stretches(part: SensingPart) -> Iterator[SensingPart]:
    """The same in stretches, each of which begins with what sensing remembered then."""
    times = [record.capture_time_ns for record in part.sets]
    for begin, end, before in _cuts(times, part.memories, part.before):
        yield replace(part, sets=part.sets[begin:end], before=before)


def control_stretches(part: ControlPart) -> Iterator[ControlPart]:
    """The same in stretches, each of which begins with what the controller remembered then."""
    times = [time_ns_in(recorded, ControllerState) for recorded in part.states]
    captured = sorted(part.shapes)
    for begin, end, before in _cuts(times, part.memories, part.before):
        mine = times[begin:end]
        seen = captured[bisect_left(captured, mine[0] - SEEN_WITHIN_NS) : bisect_left(captured, mine[-1])]
        yield ControlPart(
            states=part.states[begin:end],
            tendons={time: part.tendons[time] for time in mine if time in part.tendons},
            commands={time: part.commands[time] for time in mine if time in part.commands},
            asked={time: part.asked[time] for time in mine if time in part.asked},
            shapes={time: part.shapes[time] for time in seen},
            memories={time: part.memories[time] for time in mine if time in part.memories},
            before=before,
        )


def _before(publications: Sequence[int], memories: Sequence[Memory]) -> Memory | None:
    """The memory that the log's first step began with, if it is in there: a log that was cut may hold an older one."""
    first = memories[0] if memories and publications else None
    return first if first is not None and first.publication + 1 == publications[0] else None


def _cuts(
    times: Sequence[int], memories: Mapping[int, Memory], first: Memory | None
) -> Iterator[tuple[int, int, Memory | None]]:
    """First and last index (not included) of each stretch, and the memory before it."""
    begin, before = 0, first
    for index, time_ns in enumerate(times):
        if time_ns in memories and time_ns - times[begin] >= STRETCH_NS:
            yield begin, index + 1, before
            begin, before = index + 1, memories[time_ns]
    if begin < len(times):
        yield begin, len(times), before
