"""A whole run: where the tip was asked to go and went, and how the errors went over time."""

import itertools
from pathlib import Path
from typing import Any

from messaging.control import ControllerState, State
from nodal.report.bench_run import BenchRun, times_ns
from nodal.report.pictures.style import (
    DESIRED,
    FAINT,
    INK,
    MEASURED,
    NODE,
    WITHOUT_FEEDBACK,
    picture,
)
from nodal.report.summary import node_errors_mm
from nodal.report.tracking import Tracking, tracking_of
from nodal.report.truth import TrueShapes

PHASES = {
    "idle": "#ffffff",
    "homing": "#e9ecef",
    "ready": "#e9ecef",
    "approach": "#d6e6f4",
    "circle": "#e8f1f9",
    "hold": "#d9efdf",
    "holding": "#f6c88a",
    "fault": "#f0a3ad",
}
ROOM_FOR_A_NAME = 0.05
PLANES = (("Seen from above", 0, 1), ("Seen from the front", 0, 2))


def draw_run(
    folder: Path, run: BenchRun, truth: TrueShapes, circle: Tracking, without_feedback: Tracking | None
) -> list[Path]:
    """Both pictures; returns the files."""
    files = [_errors(folder / "error.png", run, truth)]
    if len(circle.time_ns):
        files.append(_paths(folder / "path.png", circle, without_feedback))
    return files


def _paths(path: Path, circle: Tracking, without_feedback: Tracking | None) -> Path:
    """Target and true tip, from above and from the front, and the same circle without feedback."""
    with picture(path, 9.4, 4.8) as figure:
        for axes, (title, across, up) in zip(figure.subplots(1, 2), PLANES, strict=True):
            if without_feedback is not None:
                axes.plot(
                    *without_feedback.true_mm[:, 0, [across, up]].T,
                    color=WITHOUT_FEEDBACK,
                    label=f"without feedback, {without_feedback.rms_mm():.2f} mm RMS",
                )
            axes.plot(
                *circle.true_mm[:, 0, [across, up]].T,
                color=MEASURED,
                label=f"closed loop, {circle.rms_mm():.2f} mm RMS",
            )
            axes.plot(*circle.desired_mm[:, 0, [across, up]].T, "--", color=INK, linewidth=1, label="target")
            axes.set(title=title, xlabel=f"{'xyz'[across]}, mm", ylabel=f"{'xyz'[up]}, mm")
            axes.set_aspect("equal", adjustable="datalim")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return path


def _errors(path: Path, run: BenchRun, truth: TrueShapes) -> Path:
    """Tracking and estimation error over time, on logarithmic scales, over what the controller was doing."""
    start_ns = run.shapes[0].capture_time_ns
    with picture(path, 9.4, 5.4) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        for name in run.targets:
            tracking = tracking_of(run, truth, name)
            if len(tracking.time_ns):
                above.semilogy(
                    (tracking.time_ns - start_ns) / 1e9,
                    tracking.error_mm.max(axis=1),
                    ".",
                    markersize=2.5,
                    color=MEASURED,
                )
        above.set(title="True distance from the target", ylabel="mm")
        _show_phases(above, run, start_ns)

        errors = node_errors_mm(run, truth)
        time_s = (times_ns(run.covered(truth)) - start_ns) / 1e9
        below.semilogy(
            time_s, [row.max() for row in errors], color=NODE, linewidth=0.8, label="worst nodal point"
        )
        below.semilogy(time_s, [row.mean() for row in errors], color=INK, linewidth=1.0, label="mean")
        flagged = [(shape.capture_time_ns - start_ns) / 1e9 for shape in run.usable if shape.flags]
        if flagged:
            below.plot(flagged, [1e-3] * len(flagged), "|", color=DESIRED, label="flagged")
        below.set(title="Error of the estimate against the truth", xlabel="time, s", ylabel="mm")
        below.legend(loc="upper right", ncols=3)
    return path


def _show_phases(axes: Any, run: BenchRun, start_ns: int) -> None:
    """A band for each stretch of time in which the controller did one thing; its name where there is room for it."""
    whole_ns = run.states[-1].time_ns - run.states[0].time_ns if run.states else 0
    for name, states in itertools.groupby(run.states, _phase):
        stretch = [state.time_ns for state in states]
        begin_s, end_s = (stretch[0] - start_ns) / 1e9, (stretch[-1] - start_ns) / 1e9
        axes.axvspan(begin_s, end_s, color=PHASES.get(name, FAINT), alpha=0.35, linewidth=0)
        if stretch[-1] - stretch[0] > ROOM_FOR_A_NAME * whole_ns:
            axes.text(
                (begin_s + end_s) / 2,
                0.97,
                name,
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="top",
                fontsize=8,
            )


def _phase(state: ControllerState) -> str:
    if state.state is State.TRACKING:
        return state.target_name.removeprefix("demo-")
    return "holding" if state.state is State.HOLD else str(state.state)
