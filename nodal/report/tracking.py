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
        late = self.time_ns >= (self.time_ns[0] + self.time_ns[-1]) / 2 if len(self.time_ns) else slice(0)
        return dataclasses.replace(
            self, time_ns=self.time_ns[late], desired_mm=self.desired_mm[late], true_mm=self.true_mm[late]
        )


def tracking_of(run: BenchRun, truth: TrueShapes, target_name: str) -> Tracking:
    """While the controller tracked this target."""
    target = run.targets.get(target_name)
    states = [
        state for state in run.states if state.state is State.TRACKING and state.target_name == target_name
    ]
    names = tuple(
        name for name, weight in zip(target.node_names, target.weights, strict=True) if weight > 0
    ) if target else ()
    arcs = run.arcs_mm(names)
    states = [state for state in states if set(names) <= set(state.node_names)]
    time_ns = np.array([state.time_ns for state in states], dtype=np.int64)
    known = truth.covers(time_ns) if len(time_ns) else np.zeros(0, bool)
    desired = np.array(
        [[state.desired_mm[state.node_names.index(name)] for name in names] for state in states]
    ).reshape(len(states), len(names), 3)
    time_ns, desired = time_ns[known], desired[known]
    true = truth.points_mm(time_ns, arcs) if len(time_ns) else np.zeros_like(desired)
    return Tracking(time_ns=time_ns, names=names, desired_mm=desired, true_mm=true)
