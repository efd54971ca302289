"""One run of a bench, as its recording tells it: what a report needs in memory, without the pictures."""

import dataclasses
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from messaging.control import ControllerState, Target, TendonCommand
from messaging.frames import CameraCalibration
from messaging.shape import ShapeEstimate, Truth
from nodal.errors import ReportError
from nodal.report.truth import TrueShapes


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
    """A run of a simulated bench, in order of time; targets by name."""

    rig: tuple[CameraCalibration, ...]
    losses: int
    frames: FrameSets = dataclasses.field(default_factory=FrameSets)
    shapes: list[ShapeEstimate] = dataclasses.field(default_factory=list)
    truths: list[Truth] = dataclasses.field(default_factory=list)
    states: list[ControllerState] = dataclasses.field(default_factory=list)
    commands: list[TendonCommand] = dataclasses.field(default_factory=list)
    targets: dict[str, Target] = dataclasses.field(default_factory=dict)

    def covered(self, truth: TrueShapes) -> list[ShapeEstimate]:
        """The usable estimates for whose capture there is a truth."""
        known = truth.covers(times_ns(self.usable))
        return [shape for shape, good in zip(self.usable, known, strict=True) if good]

    @cached_property
    def _captures(self) -> dict[int, list[int]]:
        captures: dict[int, list[int]] = {}
        for shape in self.usable:
            captures.setdefault(shape.sequence, []).append(shape.capture_time_ns)
        return captures

    @cached_property
    def usable(self) -> list[ShapeEstimate]:
        """The estimates that hold a shape, flagged ones too."""
        return [shape for shape in self.shapes if not shape.refusal]

    def driven_nodes(self, target_name: str) -> tuple[str, ...]:
        """The nodal points that a target weighs; none when it was never accepted."""
        target = self.targets.get(target_name)
        if target is None:
            return ()
        return tuple(
            name for name, weight in zip(target.node_names, target.weights, strict=True) if weight > 0
        )

    def captured_ns(self, sequence: int, before_ns: int) -> int | None:
        """When the shape with this number was captured that had been seen by then: numbers begin anew with sensing."""
        earlier = [time for time in self._captures.get(sequence, ()) if time <= before_ns]
        return earlier[-1] if earlier else None

    def arcs_mm(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Where these nodal points were last said to be (M,), in mm from the base; raises ReportError."""
        said = {
            name: float(arc)
            for shape in self.usable
            for name, arc in zip(shape.node_names, shape.node_arc_mm, strict=True)
        }
        if unknown := [name for name in names if name not in said]:
            raise ReportError(f"no estimate in the recording holds the nodal points {', '.join(unknown)}")
        return np.array([said[name] for name in names])


def times_ns(messages: Sequence[ShapeEstimate]) -> NDArray[np.int64]:
    """Capture times (N,), Unix ns."""
    return np.array([message.capture_time_ns for message in messages], dtype=np.int64)
