"""The charts of a run, by the chapter of the page that they belong to. Pure."""

import itertools
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from controller.limits import axis_name
from nodal.report import sensing_charts
from nodal.report.charts import FLOOR_MM, TIME, Chart, Series, a_second, bands, histogram, line, over_time
from nodal.report.findings import Findings
from nodal.report.summary import capture_to_command_ms, lateness_ms

Array = NDArray[np.float64]

DURATION = "duration, ms"
PLANES = (("above", "Paths from above", 0, 1), ("front", "Paths from the front", 0, 2))
BREAK = np.full(1, np.nan)
"""Between stretches of a line that do not belong together."""


def run_charts(findings: Findings) -> dict[str, tuple[Chart, ...]]:
    """Only charts that have something to show."""
    makers: dict[str, Callable[[Findings], Iterable[Chart]]] = {
        "what-happened": _timeline,
        "tracking": _tracking,
        "truth": sensing_charts.errors,
        "quality": sensing_charts.quality,
        "cameras": sensing_charts.cameras,
        "sensing": sensing_charts.sensing,
        "latency": _latency,
        "loop": _loop,
        "tendons": _tendons,
    }
    return {
        chapter: tuple(
            chart for chart in maker(findings) if chart.bands or any(len(series.x) for series in chart.series)
        )
        for chapter, maker in makers.items()
    }


def _timeline(findings: Findings) -> Iterable[Chart]:
    """States of the controller, and above them everything that went wrong, each where it did."""
    run = findings.run
    rows = {
        "log warns": [line.time_ns for line in findings.warnings],
        "flagged": [shape.capture_time_ns for shape in run.usable if shape.flags],
        "refused": [shape.capture_time_ns for shape in run.shapes if shape.refusal],
        "restart": [time_ns for time_ns, _ in run.restarts],
        "asked": [asked.time_ns for asked in run.asked],
        "fault": [fault.begin_ns for fault in findings.faults],
    }
    rows = {name: times_ns for name, times_ns in rows.items() if times_ns}
    yield Chart(
        key="timeline",
        title="What the controller did, and what came up",
        x_label=TIME,
        y_label="",
        series=tuple(
            line(name, [findings.second(time) for time in times], np.full(len(times), row), row, "ticks")
            for row, (name, times) in enumerate(rows.items())
        ),
        bands=bands(findings.stretches, run.start_ns),
        rows=tuple(rows),
        wide=True,
    )


def _tracking(findings: Findings) -> Iterable[Chart]:
    background = bands(findings.stretches, findings.run.start_ns)
    kinds = {"true": findings.true, "measured": findings.measured}
    known = {kind: list(trackings.values()) for kind, trackings in kinds.items() if trackings}
    yield Chart(
        key="tracking-error",
        title="Distance from the target",
        x_label=TIME,
        y_label="worst nodal point, mm",
        series=tuple(
            over_time(
                kind,
                _joined(findings.since_start_s(tracking.time_ns) for tracking in trackings),
                _joined(tracking.error_mm.max(axis=1, initial=FLOOR_MM) for tracking in trackings),
                colour,
            )
            for colour, (kind, trackings) in enumerate(known.items())
        ),
        logarithmic="y",
        bands=background,
        wide=True,
    )
    for key, title, across, up in PLANES:
        yield Chart(
            key=f"path-{key}",
            title=title,
            x_label=f"{'xyz'[across]}, mm",
            y_label=f"{'xyz'[up]}, mm",
            series=(
                *(
                    _path(kind, [t.reached_mm for t in trackings], (across, up), colour)
                    for colour, (kind, trackings) in enumerate(known.items())
                ),
                _path("target", [t.desired_mm for t in next(iter(known.values()), [])], (across, up), -1),
            ),
            equal=True,
        )


def _path(label: str, places_mm: Sequence[Array], plane: tuple[int, int], colour: int) -> Series:
    """Every nodal point of every target; the target itself, which has no colour of its own, in dashes."""
    lines = [places[:, node] for places in places_mm for node in range(places.shape[1])]
    across, up = (_joined(points[:, axis] for points in lines) for axis in plane)
    return line(label, across, up, colour, "dashes" if colour < 0 else "line")


def _latency(findings: Findings) -> Iterable[Chart]:
    run = findings.run
    yield Chart(
        key="latency",
        title="Latencies",
        x_label=DURATION,
        y_label="share, %",
        series=(
            histogram("capture to command", capture_to_command_ms(run), 0),
            histogram("capture to publish", [s.capture_to_publish_ns / 1e6 for s in run.shapes], 2),
        ),
        logarithmic="x",
    )
    answers = [command for command in run.commands if command.capture_to_command_ns >= 0]
    yield Chart(
        key="latency-over-time",
        title="Capture to command over time",
        x_label=TIME,
        y_label="ms",
        series=(
            over_time(
                "capture to command",
                [findings.second(command.time_ns) for command in answers],
                capture_to_command_ms(run),
            ),
        ),
    )


def _loop(findings: Findings) -> Iterable[Chart]:
    run = findings.run
    yield Chart(
        key="loop",
        title="The control loop",
        x_label=DURATION,
        y_label="share of cycles, %",
        series=(
            histogram("lateness", lateness_ms(run), 0),
            histogram("work", [1e3 * state.busy_s for state in run.states], 2),
        ),
        logarithmic="x",
    )
    yield Chart(
        key="cycles-a-second",
        title="Cycles in each second",
        x_label=TIME,
        y_label="cycles",
        series=(a_second("cycles", [findings.second(state.time_ns) for state in run.states]),),
    )


def _tendons(findings: Findings) -> Iterable[Chart]:
    run = findings.run
    time_s = [findings.second(state.time_ns) for state in run.tendons]
    travel = np.array([state.position_mm for state in run.tendons])
    tendons = len(run.tendons[0].displacement_mm) if run.tendons else 0
    current = np.array([state.current_ma for state in run.tendons])
    for key, title, unit, values in (
        ("travel", "Displacement of tendon pairs and stage", "mm", travel),
        ("current", "Current of the servos", "mA", current),
    ):
        axes = values.shape[1] if values.ndim > 1 else 0
        yield Chart(
            key=key,
            title=title,
            x_label=TIME,
            y_label=unit,
            series=tuple(
                over_time(axis_name(axis, tendons), time_s, values[:, axis], axis) for axis in range(axes)
            ),
            wide=True,
        )


def _joined(pieces: Iterable[Array]) -> Array:
    return np.concatenate([np.zeros(0), *itertools.chain(*((piece, BREAK) for piece in pieces))])
