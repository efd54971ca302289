"""A whole run: where the tip was asked to go and went, and how the errors went over time."""

from pathlib import Path
from typing import Any

from messaging.control import State
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
from nodal.report.tracking import Tracking
from nodal.report.truth import TrueShapes

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
    """Tracking and estimation error over time, on a logarithmic scale, over the controller's states."""
    start_ns = run.shapes[0].capture_time_ns
    with picture(path, 9.4, 5.4) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        tracked = [state for state in run.states if state.target_name and state.state is State.TRACKING]
        above.semilogy(
            [(state.time_ns - start_ns) / 1e9 for state in tracked],
            [max(state.tracking_error_mm, 1e-3) for state in tracked],
            ".",
            markersize=1.5,
            color=MEASURED,
        )
        above.set(title="Tracking error as the controller sees it", ylabel="mm")
        _shade_states(above, run, start_ns)

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


def _shade_states(axes: Any, run: BenchRun, start_ns: int) -> None:
    changes = [
        (previous, state)
        for previous, state in zip(run.states, run.states[1:], strict=False)
        if (previous.state, previous.target_name) != (state.state, state.target_name)
    ]
    for _, state in changes:
        moment_s = (state.time_ns - start_ns) / 1e9
        axes.axvline(moment_s, color=FAINT, linewidth=1)
        label = state.target_name.removeprefix("demo-") if state.state is State.TRACKING else str(state.state)
        axes.text(
            moment_s,
            1.0,
            f" {label}",
            transform=axes.get_xaxis_transform(),
            rotation=90,
            va="top",
            fontsize=7,
        )
