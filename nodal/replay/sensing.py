"""Sensing over a log: each frame set through `sensing.step`, with what sensing carried from the set before."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from messaging import topics
from messaging.errors import NodalError
from messaging.history import Memory
from messaging.shape import NodalPoints, ShapeEstimate
from nodal.bench_file import Bench
from nodal.replay.comparison import Comparison, compared, compared_bytes, skipped
from nodal.replay.frame_sets import FrameSetRecord, pictured
from recordings.log import Log
from sensing.memory import SensingMemory, TrackMemory
from sensing.method import Method, bench_method
from sensing.refined.track import Track
from sensing.scene import Scene
from sensing.set_inputs import SetInputs
from sensing.step import Clocks, step

KEY, MEMORY_KEY = topics.SHAPE.key, topics.SENSING_MEMORY.key
STILL = Clocks(stage_s=lambda: 0.0, age_ns=lambda: 0)
"""A replay takes no time that anybody should see."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SensingPart:
    """A stretch of one log: its sets, memories by capture time, and nodal points by the time they were named (both ns)."""

    path: Path
    sets: Sequence[FrameSetRecord]
    memories: Mapping[int, Memory]
    named: Sequence[tuple[int, NodalPoints]]
    before: Memory | None
    """The memory with which the stretch begins, if there is one."""


class _Carried:
    """What sensing carries on, as far as the log tells: `unknown` says why nothing can be replayed just now."""

    def __init__(self, bench: Bench, scene: Scene) -> None:
        self._scene = scene
        self._configured = bench.settings.sensing.points
        self.points = self._configured
        self.track: Track | None = None
        self.unknown = "it stands before the first memory in the log"

    def begin(self) -> None:
        """Sensing starts: it remembers nothing."""
        self.points, self.track, self.unknown = self._configured, None, ""

    def lose(self, reason: str) -> None:
        """The chain breaks here; if it was broken before, that is why nothing is known."""
        self.unknown = self.unknown or reason

    def recall(self, logged: Memory) -> None:
        """Take a logged memory for granted."""
        try:
            memory = SensingMemory.from_bytes(logged.content)
            self.track = None if memory.track is None else memory.track.track(self._scene)
        except NodalError as error:
            self.unknown = f"the memory before it cannot be used: {error}"
            return
        self.points, self.unknown = memory.points, ""

    def memory(self) -> bytes:
        """What would be logged now."""
        track = None if self.track is None else TrackMemory.of(self.track)
        return SensingMemory(track=track, points=self.points).to_bytes()


def verify(part: SensingPart, bench: Bench) -> Comparison:
    """Every logged estimate against what sensing makes of the same pictures and the same memory."""
    method = _method_of(bench)
    carried = _Carried(bench, method.scene)
    if part.before is not None:
        carried.recall(part.before)
    found = Comparison()
    last: FrameSetRecord | None = None
    named_since_ns = 0 if part.before is None else part.before.time_ns
    for record, jpegs in pictured(Log(part.path), part.sets, tuple(bench.settings.cameras)):
        if record.publication == 0:
            carried.begin()
        elif last is not None and record.publication != last.publication + 1:
            carried.lose("an estimate between the memory and it is missing from the log")
        if jpegs is None:
            carried.lose("a frame is missing from the log")
        carried.points = _named(part.named, named_since_ns, record.publish_time_ns) or carried.points
        if carried.unknown or jpegs is None or record.estimate is None:
            found += skipped(KEY, carried.unknown)
        else:
            inputs = inputs_of(record, jpegs, carried.points)
            estimate, carried.track, _ = step(method, inputs, carried.track, STILL)
            found += compared(KEY, record.capture_time_ns, record.estimate, estimate)
        if (logged := part.memories.get(record.capture_time_ns)) is not None:
            mine = b"" if carried.unknown else carried.memory()
            if not carried.unknown:
                found += compared_bytes(MEMORY_KEY, record.capture_time_ns, logged.content, mine)
            if mine != logged.content:
                carried.recall(logged)
        last, named_since_ns = record, record.publish_time_ns
    return found


def imagine(
    part: SensingPart, bench: Bench, points: NodalPoints | None
) -> Iterator[tuple[FrameSetRecord, ShapeEstimate, bytes]]:
    """What sensing would have made of every set, beginning without memory: the estimate, as old as then, and the memory.

    `points` are reported in place of those that were asked for, if given. Sets without all their pictures are left out.
    """
    method = _method_of(bench)
    carried = _Carried(bench, method.scene)
    carried.begin()
    named_since_ns = 0
    for record, jpegs in pictured(Log(part.path), part.sets, tuple(bench.settings.cameras)):
        if record.publication == 0:
            carried.begin()
        named = _named(part.named, named_since_ns, record.publish_time_ns)
        carried.points = points or named or carried.points
        named_since_ns = record.publish_time_ns
        if jpegs is not None:
            clocks = replace(STILL, age_ns=partial(int, record.age_ns))
            inputs = inputs_of(record, jpegs, carried.points)
            estimate, carried.track, _ = step(method, inputs, carried.track, clocks)
            yield record, estimate, carried.memory()


def inputs_of(record: FrameSetRecord, jpegs: Mapping[str, bytes], points: NodalPoints) -> SetInputs:
    """What the step of this set saw."""
    return SetInputs(
        jpegs=jpegs,
        sequence=record.sequence,
        capture_time_ns=record.capture_time_ns,
        insertion_mm=record.insertion_mm,
        base_known=record.base_known,
        points=points,
    )


def _method_of(bench: Bench) -> Method:
    return bench_method(bench.settings.sensing, bench.settings.robot, bench.rig, bench.backgrounds)


def _named(named: Sequence[tuple[int, NodalPoints]], since_ns: int, until_ns: int) -> NodalPoints | None:
    """The nodal points that an operator named last between these publish times, if any."""
    between = [points for time_ns, points in named if since_ns < time_ns < until_ns]
    return between[-1] if between else None
