"""How far the nodal points were from where they should have been: as the cameras measured it, and in truth. Pure."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from nodal.report.bench_run import BenchRun
from nodal.report.stretches import Pursuit, pursuits
from nodal.report.truth import TrueShapes

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Tracking:
    """One target's weighted nodal points (M of them) at N captures; positions in mm, robot frame."""

    time_ns: NDArray[np.int64]
    names: tuple[str, ...]
    arc_mm: Array
    """(N, M) where the points were on the centreline; an operator may name others at any time."""
    desired_mm: Array
    reached_mm: Array

    @classmethod
    def nothing(cls) -> "Tracking":
        """Of a target that was never gone after."""
        return cls(
            time_ns=np.zeros(0, np.int64),
            names=(),
            arc_mm=np.zeros((0, 0)),
            desired_mm=np.zeros((0, 0, 3)),
            reached_mm=np.zeros((0, 0, 3)),
        )

    @property
    def error_mm(self) -> Array:
        """(N, M) distances."""
        return np.asarray(np.linalg.norm(self.reached_mm - self.desired_mm, axis=-1))

    def rms_mm(self) -> float | None:
        """Over all captures and points; None when there is none."""
        return float(np.sqrt((self.error_mm**2).mean())) if self.error_mm.size else None

    def by_truth(self, truth: TrueShapes) -> "Tracking":
        """The same with the points where they truly were, as far as the truth is known."""
        covered = self._only(truth.covers(self.time_ns))
        true_mm = np.empty_like(covered.reached_mm)
        for arcs in np.unique(covered.arc_mm, axis=0):
            rows = (covered.arc_mm == arcs).all(axis=1)
            true_mm[rows] = truth.points_mm(covered.time_ns[rows], arcs)
        return dataclasses.replace(covered, reached_mm=true_mm)

    def second_half(self) -> "Tracking":
        """What is left when the first half of the time is taken as settling."""
        return (
            self._only(self.time_ns >= (self.time_ns.min() + self.time_ns.max()) / 2)
            if self.time_ns.size
            else self
        )

    def first(self, seconds: float) -> "Tracking":
        """The beginning."""
        return self._only(self.time_ns <= self.time_ns.min() + seconds * 1e9) if self.time_ns.size else self

    def _only(self, rows: NDArray[np.bool_]) -> "Tracking":
        return dataclasses.replace(
            self,
            time_ns=self.time_ns[rows],
            arc_mm=self.arc_mm[rows],
            desired_mm=self.desired_mm[rows],
            reached_mm=self.reached_mm[rows],
        )


def tracking_of(run: BenchRun, pursuit: Pursuit) -> Tracking:
    """As it was measured while the controller tracked this target, once for each shape that it acted on.

    The controller says where the points should have been and where they were when the shape was captured.
    """
    names = pursuit.names
    rows: dict[int, tuple[Array, Array, Array]] = {}
    for state in pursuit.followed:
        shape = run.shape_seen(state.shape_sequence, state.time_ns)
        if shape is None or shape.capture_time_ns in rows or not set(names) <= set(shape.node_names):
            continue
        order = [state.node_names.index(name) for name in names]
        arcs = shape.node_arc_mm[[shape.node_names.index(name) for name in names]]
        rows[shape.capture_time_ns] = arcs, state.desired_mm[order], state.measured_mm[order]
    if not rows:
        return Tracking.nothing()
    time_ns = sorted(rows)
    arc_mm, desired_mm, reached_mm = (
        np.array(column) for column in zip(*(rows[time] for time in time_ns), strict=True)
    )
    return Tracking(
        time_ns=np.array(time_ns, dtype=np.int64),
        names=names,
        arc_mm=arc_mm,
        desired_mm=desired_mm,
        reached_mm=reached_mm,
    )


def true_tracking_of(run: BenchRun, truth: TrueShapes, target_name: str) -> Tracking:
    """How the newest target of this name was tracked in truth; nothing when there was none."""
    found = [pursuit for pursuit in pursuits(run) if pursuit.target and pursuit.target.name == target_name]
    return tracking_of(run, found[-1]).by_truth(truth) if found else Tracking.nothing()
