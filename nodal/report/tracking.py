"""How far the true nodal points were from where they should have been. Pure."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from messaging.control import State
from nodal.report.bench_run import BenchRun
from nodal.report.truth import TrueShapes

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Tracking:
    """One target's weighted nodal points (M of them) at N cycles of the controller; positions in mm, robot frame."""

    time_ns: NDArray[np.int64]
    names: tuple[str, ...]
    desired_mm: Array
    true_mm: Array

    @property
    def error_mm(self) -> Array:
        """(N, M) distances."""
        return np.asarray(np.linalg.norm(self.true_mm - self.desired_mm, axis=-1))

    def rms_mm(self) -> float | None:
        """Over all cycles and points; None when there is none."""
        return float(np.sqrt((self.error_mm**2).mean())) if self.error_mm.size else None

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
            self, time_ns=self.time_ns[rows], desired_mm=self.desired_mm[rows], true_mm=self.true_mm[rows]
        )


def tracking_of(run: BenchRun, truth: TrueShapes, target_name: str) -> Tracking:
    """While the controller tracked this target, once for each shape that it acted on; raises ReportError.

    The controller says where the points should have been when the shape was captured, so the truth is taken then.
    """
    names = run.driven_nodes(target_name)
    rows: dict[int, Array] = {}
    for state in run.states:
        if state.state is State.TRACKING and state.target_name == target_name:
            captured_ns = run.captured_ns(state.shape_sequence, state.time_ns)
            if captured_ns is not None:
                order = [state.node_names.index(name) for name in names]
                rows.setdefault(captured_ns, state.desired_mm[order])
    time_ns = np.array(sorted(rows), dtype=np.int64)
    time_ns = time_ns[truth.covers(time_ns)]
    return Tracking(
        time_ns=time_ns,
        names=names,
        desired_mm=np.array([rows[time] for time in time_ns.tolist()]).reshape(len(time_ns), len(names), 3),
        true_mm=truth.points_mm(time_ns, run.arcs_mm(names)),
    )
