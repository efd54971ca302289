"""What figures, charts and words of a report are made of, worked out once for a run. Pure."""

from collections import Counter
from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from messaging.control import State
from messaging.shape import ShapeEstimate
from nodal.report.bench_run import BenchRun, Line, times_ns
from nodal.report.confidence import inside
from nodal.report.stretches import Pursuit, Stretch, pursuits, stretches, without_numbers
from nodal.report.summary import node_offsets_mm, tip_errors_mm
from nodal.report.tracking import Tracking, tracking_of

Array = NDArray[np.float64]

WARNING = 30
"""The level in Python's logging module from which on a line is worth a reader's time."""


class Findings:
    """Everything that follows from a run alone."""

    def __init__(self, run: BenchRun) -> None:
        self.run = run

    @cached_property
    def stretches(self) -> list[Stretch]:
        """What the controller was doing, in order of time."""
        return stretches(self.run.states)

    @property
    def faults(self) -> list[Stretch]:
        """Each time that the controller was in fault."""
        return [stretch for stretch in self.stretches if stretch.state is State.FAULT]

    @property
    def waits(self) -> list[Stretch]:
        """Each hold that no operator asked for."""
        return [stretch for stretch in self.stretches if stretch.by_itself]

    @cached_property
    def pursuits(self) -> list[Pursuit]:
        """The targets that were gone after."""
        return pursuits(self.run)

    @cached_property
    def measured(self) -> dict[str, Tracking]:
        """How each target was tracked as the cameras saw it, by the pursuit's label."""
        return {pursuit.label: tracking_of(self.run, pursuit) for pursuit in self.pursuits}

    @cached_property
    def true(self) -> dict[str, Tracking]:
        """The same in truth; empty where there is none."""
        truth = self.run.truth
        return {label: tracking.by_truth(truth) for label, tracking in self.measured.items()} if truth else {}

    @property
    def tracking(self) -> dict[str, Tracking]:
        """The best that is known of each target: in truth where there is one, as measured otherwise."""
        return self.true or self.measured

    @cached_property
    def covered(self) -> list[ShapeEstimate]:
        """The usable estimates that the truth covers."""
        return self.run.covered(self.run.truth) if self.run.truth else []

    @cached_property
    def node_offsets_mm(self) -> list[Array]:
        """Of each of them, where its nodal points lie from the truth (M, 3)."""
        return node_offsets_mm(self.run, self.run.truth) if self.run.truth else []

    @cached_property
    def node_errors_mm(self) -> list[Array]:
        """Of each of them, the distances (M,) of its nodal points from the truth."""
        return [np.linalg.norm(offsets, axis=1) for offsets in self.node_offsets_mm]

    @cached_property
    def inside(self) -> list[NDArray[np.bool_]]:
        """Of the same estimates, whether each nodal point (M,) was in truth within its 95 % ellipsoid."""
        return [
            inside(errors, shape.node_covariance_mm2)
            for errors, shape in zip(self.node_offsets_mm, self.covered, strict=True)
        ]

    @cached_property
    def tip_errors_mm(self) -> Array:
        """(N,) of the same estimates, the distance of the centreline's end."""
        return tip_errors_mm(self.run, self.run.truth) if self.run.truth else np.zeros(0)

    @cached_property
    def error_time_s(self) -> Array:
        """(N,) when these estimates were captured."""
        return self.since_start_s(times_ns(self.covered))

    @cached_property
    def sigmas_mm(self) -> list[Array]:
        """Of each usable estimate, the standard deviations (M,) that it claims for its nodal points."""
        return [np.sqrt(np.trace(shape.node_covariance_mm2, axis1=1, axis2=2)) for shape in self.run.usable]

    @cached_property
    def cameras(self) -> tuple[str, ...]:
        """The cameras that carried an estimate, in the order in which they first did."""
        return tuple(dict.fromkeys(name for shape in self.run.usable for name in shape.camera_names))

    def by_camera(self, values: Callable[[ShapeEstimate], Array]) -> dict[str, Array]:
        """What usable estimates say of each camera (N,); NaN where one did not carry an estimate."""
        told = {name: np.full(len(self.run.usable), np.nan) for name in self.cameras}
        for row, shape in enumerate(self.run.usable):
            for name, value in zip(shape.camera_names, values(shape).tolist(), strict=True):
                told[name][row] = value
        return told

    @cached_property
    def epipolar_deg(self) -> Array:
        """(N,) the smallest angle of each usable estimate's centreline to the epipolar direction."""
        return np.array(
            [np.degrees(shape.epipolar_angle_rad.min(initial=np.pi / 2)) for shape in self.run.usable]
        )

    @cached_property
    def methods(self) -> Counter[str]:
        """How many frame sets each method looked at."""
        return Counter(shape.method for shape in self.run.shapes)

    @cached_property
    def warnings(self) -> list[Line]:
        """Lines of the log that warn or worse."""
        return [line for line in self.run.lines if line.level >= WARNING]

    @cached_property
    def flags(self) -> Counter[str]:
        """How often each flag was raised."""
        return Counter(flag for shape in self.run.usable for flag in shape.flags)

    @cached_property
    def refusals(self) -> Counter[str]:
        """How often each kind of refusal was given, whatever its numbers."""
        return kinds(shape.refusal for shape in self.run.shapes if shape.refusal)

    def since_start_s(self, time_ns: NDArray[np.int64]) -> Array:
        """Seconds since the recording began."""
        return np.asarray((time_ns - self.run.start_ns) / 1e9)

    def second(self, time_ns: int) -> float:
        """Seconds since the recording began."""
        return (time_ns - self.run.start_ns) / 1e9


def kinds(reasons: Iterable[str]) -> Counter[str]:
    """How often each was given, those that differ only in their numbers counted as one."""
    return Counter(without_numbers(reason) for reason in reasons)
