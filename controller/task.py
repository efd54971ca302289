"""One stretch of closed-loop motion: a reference, the law that follows it, and how well it goes. Pure."""

import dataclasses
import math
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controller.faults import LawFailedError
from controller.law import SAME_ARC_MM, Beginning, Desired, Law, LawInputs, Measurement, Points
from controller.reference import Reference
from drivers.actuators import ActuatorState
from messaging.control import Target
from messaging.shape import ShapeEstimate
from messaging.snapshot import freeze

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """A trusted shape, when its frames were taken and when it arrived, on the loop's clock."""

    shape: ShapeEstimate
    capture_s: float
    arrived_s: float

    def measurement(self, names: tuple[str, ...]) -> Measurement:
        """All nodal points, with these led; raises ValueError for a name that is not there."""
        return Measurement(
            capture_s=self.capture_s,
            arc_mm=self.shape.node_arc_mm,
            node_mm=self.shape.node_mm,
            covariance_mm2=self.shape.node_covariance_mm2,
            led=np.array([self.shape.node_names.index(name) for name in names], dtype=np.intp),
        )


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """The motion at one moment. `desired_mm` and `measured_mm` (m, 3) both belong to the newest shape's capture."""

    reference: Reference
    points: Points
    law_state: Any
    desired_mm: Array
    measured_mm: Array
    error_mm: float
    """Weighted RMS distance between the two."""

    def straight(self, within_mm: float, now_s: float) -> bool:
        """True when the reference has arrived and the nodal points are near the axis, wherever along it.

        A robot that is a little longer or shorter than it was drawn is straight all the same.
        """
        off_axis_mm = math.sqrt(float((self.measured_mm[:, :2] ** 2).sum(axis=1).mean()))
        return self.reference.joined(now_s) and off_axis_mm < within_mm


def begin(
    law: Law[Any],
    reference: Reference,
    seen: Seen,
    movable: NDArray[np.bool_],
    *,
    before: Any,
    command_mm: Array,
    lost_motion_mm: Array,
    now_s: float,
) -> Task:
    """A task that starts from what is seen now, with what the law remembers of `before`; raises LawFailedError."""
    measurement = seen.measurement(reference.target.node_names)
    points = Points(
        arc_mm=measurement.arc_mm[measurement.led], weights=reference.target.weights, movable=movable
    )
    beginning = Beginning(
        points=points,
        command_mm=command_mm,
        measured=measurement,
        now_s=now_s,
        lost_motion_mm=lost_motion_mm,
        before=before,
    )
    with _law_at_work():
        law_state = law.start(beginning)
        freeze(law_state)  # what cannot be kept cannot be replayed; better now than in the middle of a motion
    return Task(
        reference=reference, points=points, law_state=law_state, **_compare(reference, points, measurement)
    )


def advance(
    law: Law[Any],
    task: Task,
    seen: Seen | None,
    *,
    command_mm: Array,
    drive: ActuatorState | None,
    now_s: float,
    dt_s: float,
) -> tuple[Task, Array]:
    """The task one cycle on, and the command (A,) that the law asks for; raises LawFailedError.

    `seen` is a shape that arrived just now.
    """
    measured = None if seen is None else seen.measurement(task.reference.target.node_names)
    inputs = LawInputs(
        now_s=now_s,
        dt_s=dt_s,
        command_mm=command_mm,
        drive=drive,
        desired=task.reference.at(now_s + law.lead_s),
        measured=measured,
    )
    with _law_at_work():
        law_state, answer = law.step(task.law_state, inputs)
        wanted = np.asarray(answer, dtype=np.float64)
    seen_anew = {} if measured is None else _compare(task.reference, task.points, measured)
    return dataclasses.replace(task, law_state=law_state, **seen_anew), wanted


@contextmanager
def _law_at_work() -> Iterator[None]:
    """Whatever a law does wrong must not end the process: it may be a stranger's, and torque is on."""
    try:
        yield
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        raise LawFailedError(
            f"the law failed: {type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        ) from error


def _compare(reference: Reference, points: Points, measured: Measurement) -> dict[str, Any]:
    desired_mm = reference.at(measured.capture_s).node_mm
    squared = ((desired_mm - measured.led_mm) ** 2).sum(axis=1)
    error_mm = math.sqrt(squared @ points.weights / points.weights.sum())
    return {"desired_mm": desired_mm, "measured_mm": measured.led_mm, "error_mm": error_mm}


def straight_target(shape: ShapeEstimate) -> Target:
    """Every nodal point on the axis, where it is on a straight robot."""
    on_axis = np.outer(shape.insertion_mm + shape.node_arc_mm, [0.0, 0.0, 1.0])
    return Target(
        name="straight",
        node_names=shape.node_names,
        weights=np.ones(len(on_axis)),
        time_s=np.zeros(1),
        position_mm=on_axis[None],
        repeat=False,
    )


def starting_points(target: Target, seen: Seen, task: Task | None, now_s: float) -> Desired:
    """Where a new reference begins: as nodal points are led just now, or standing where they are seen."""
    start_mm = seen.measurement(target.node_names).led_mm.copy()
    start_mm_s = np.zeros_like(start_mm)
    if task is not None:
        led, names = task.reference.at(now_s), task.reference.target.node_names
        for row, name in enumerate(target.node_names):
            if name in names:
                start_mm[row] = led.node_mm[names.index(name)]
                start_mm_s[row] = led.velocity_mm_s[names.index(name)]
    return Desired(node_mm=start_mm, velocity_mm_s=start_mm_s)


def missing_nodes(names: tuple[str, ...], shape: ShapeEstimate) -> str:
    """Which of these nodal points the shape lacks, in words."""
    missing = ", ".join(name for name in names if name not in shape.node_names)
    return f"the shape has no nodal point {missing}" if missing else ""


def misfit(task: Task, shape: ShapeEstimate) -> str:
    """Why this shape is of no use to the task, or nothing: its nodal points were renamed or moved along the robot."""
    names = task.reference.target.node_names
    if missing := missing_nodes(names, shape):
        return missing
    rows = [shape.node_names.index(name) for name in names]
    shift = np.abs(shape.node_arc_mm[rows] - task.points.arc_mm).max()
    return f"nodal points were moved by {shift:.1f} mm along the robot" if shift > SAME_ARC_MM else ""
