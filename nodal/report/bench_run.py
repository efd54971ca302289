"""One run of a bench, as its recording tells it: what a report needs in memory, without the pictures."""

import dataclasses
import logging
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from messaging.control import ControllerState, Target, TendonCommand, TendonState
from messaging.frames import CameraCalibration
from messaging.history import Asked
from messaging.shape import ShapeEstimate, Truth
from nodal.report.traffic import TopicTraffic, restarts
from nodal.report.truth import TrueShapes


@dataclasses.dataclass(frozen=True, kw_only=True)
class Line:
    """A line of the log; `level` is a number of Python's logging module."""

    time_ns: int
    level: int
    process: str
    text: str

    @property
    def level_name(self) -> str:
        """INFO, WARNING, ERROR ..."""
        return logging.getLevelName(self.level)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Accepted:
    """A target that the controller took up, and when it said so (Unix ns)."""

    time_ns: int
    target: Target


class FrameSets:
    """Counts frame sets by the sequence numbers of the cameras' frames. Numbers that fall back begin a new life of sensing."""

    def __init__(self) -> None:
        self._seen: dict[str, set[tuple[int, int]]] = {}
        self._last: dict[str, tuple[int, int]] = {}

    def hear(self, camera: str, sequence: int) -> None:
        """One camera's frame, in order of recording."""
        life, last = self._last.get(camera, (0, -1))
        self._last[camera] = (life + (sequence < last), sequence)
        self._seen.setdefault(camera, set()).add(self._last[camera])

    def complete(self) -> int:
        """How many sets hold every camera's frame."""
        return len(set.intersection(*self._seen.values())) if self._seen else 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class BenchRun:
    """A run of a bench, in order of time. Nothing need be there: a recording may hold any part of what a bench says."""

    rig: tuple[CameraCalibration, ...]
    losses: int
    frames: FrameSets = dataclasses.field(default_factory=FrameSets)
    shapes: list[ShapeEstimate] = dataclasses.field(default_factory=list)
    truths: list[Truth] = dataclasses.field(default_factory=list)
    states: list[ControllerState] = dataclasses.field(default_factory=list)
    commands: list[TendonCommand] = dataclasses.field(default_factory=list)
    tendons: list[TendonState] = dataclasses.field(default_factory=list)
    accepted: list[Accepted] = dataclasses.field(default_factory=list)
    asked: list[Asked] = dataclasses.field(default_factory=list)
    lines: list[Line] = dataclasses.field(default_factory=list)
    traffic: dict[str, TopicTraffic] = dataclasses.field(default_factory=dict)

    @property
    def start_ns(self) -> int:
        """When the first publication was logged; 0 when there is none."""
        return min((topic.first_ns for topic in self.traffic.values()), default=0)

    @property
    def end_ns(self) -> int:
        """When the last publication was logged; 0 when there is none."""
        return max((topic.last_ns for topic in self.traffic.values()), default=0)

    @cached_property
    def restarts(self) -> list[tuple[int, str]]:
        """When which process began anew in the middle of the recording."""
        return restarts(self.traffic)

    @cached_property
    def truth(self) -> TrueShapes | None:
        """The true shapes; None when the recording holds fewer than two, as a real bench's does."""
        return TrueShapes(self.truths) if len(self.truths) > 1 else None

    def covered(self, truth: TrueShapes) -> list[ShapeEstimate]:
        """The usable estimates for whose capture there is a truth."""
        known = truth.covers(times_ns(self.usable))
        return [shape for shape, good in zip(self.usable, known, strict=True) if good]

    @cached_property
    def _by_number(self) -> dict[int, list[ShapeEstimate]]:
        numbered: dict[int, list[ShapeEstimate]] = {}
        for shape in self.usable:
            numbered.setdefault(shape.sequence, []).append(shape)
        return numbered

    @cached_property
    def usable(self) -> list[ShapeEstimate]:
        """The estimates that hold a shape, flagged ones too."""
        return [shape for shape in self.shapes if not shape.refusal]

    def shape_seen(self, sequence: int, before_ns: int) -> ShapeEstimate | None:
        """The shape with this number that had been captured by then: numbers begin anew with sensing."""
        earlier = [s for s in self._by_number.get(sequence, ()) if s.capture_time_ns <= before_ns]
        return earlier[-1] if earlier else None


def times_ns(messages: Sequence[ShapeEstimate]) -> NDArray[np.int64]:
    """Capture times (N,), Unix ns."""
    return np.array([message.capture_time_ns for message in messages], dtype=np.int64)
