"""Which figures a paper may want of a run, each as rows of charts. Pure."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from controller.limits import axis_name
from messaging.control import State
from nodal.report.bench_run import times_ns
from nodal.report.charts import TIME, Band, Chart, Series, bands, histogram, over_time
from nodal.report.findings import Findings
from nodal.report.run_charts import DURATION, run_charts
from nodal.report.summary import capture_to_command_ms
from nodal.report.tracking import Tracking

Array = NDArray[np.float64]
Rows = tuple[tuple[Chart, ...], ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Figure:
    """Rows of charts that have something to show, over one axis of time or each over its own; `needs` names topics."""

    name: str
    rows: Rows
    needs: str
    one_time_axis: bool = False


def figures(findings: Findings) -> tuple[Figure, ...]:
    """Every figure; one without rows has nothing to show."""
    report = {chart.key: chart for chapter in run_charts(findings).values() for chart in chapter}
    own = {chart.key: chart for chart in (*_coordinates(findings), _travel(findings), _latency(findings))}
    charts = {
        key: chart for key, chart in (report | own).items() if any(len(series.x) for series in chart.series)
    }

    def rows(*keys: tuple[str, ...]) -> Rows:
        found = (tuple(charts[key] for key in row if key in charts) for row in keys)
        return tuple(row for row in found if row)

    return (
        Figure(name="nodal-points", rows=rows(("x",), ("y",), ("z",)), needs="shape", one_time_axis=True),
        Figure(
            name="tracking-error", rows=rows(("tracking-error",)), needs="shape, controller/state and target"
        ),
        Figure(name="estimate-error", rows=rows(("estimate-error",)), needs="shape and truth"),
        Figure(
            name="tendons",
            rows=rows(("travel",), ("current",)),
            needs="tendon/state or tendon/command",
            one_time_axis=True,
        ),
        Figure(name="latency", rows=rows(("latency",)), needs="shape, tendon/command or controller/state"),
        Figure(name="loop", rows=rows(("loop", "cycles-a-second")), needs="controller/state"),
        Figure(
            name="quality",
            rows=rows(("sigma", "epipolar"), ("ray-gap", "length"), ("camera-residual", "visible")),
            needs="shape",
        ),
    )


def _coordinates(findings: Findings) -> list[Chart]:
    """Each coordinate of the nodal points over time, and of the places where those that count should have been."""
    usable = findings.run.usable
    time_s = findings.since_start_s(times_ns(usable))
    names = tuple(dict.fromkeys(name for shape in usable for name in shape.node_names))
    places = np.full((len(usable), len(names), 3), np.nan)
    for row, shape in enumerate(usable):
        places[row, [names.index(name) for name in shape.node_names]] = shape.node_mm
    trackings = list(findings.measured.values())
    asked_s = np.concatenate([np.zeros(0), *(findings.since_start_s(t.time_ns) for t in trackings)])
    background = bands(findings.stretches, findings.run.start_ns)
    charts = []
    for axis, letter in enumerate("xyz"):
        measured = [
            over_time(name, time_s, places[:, number, axis], number) for number, name in enumerate(names)
        ]
        most = max((t.desired_mm.shape[1] for t in trackings), default=0)
        asked = [
            _dashed("target" if not number else "", asked_s, _asked(trackings, number, axis))
            for number in range(most)
        ]
        charts.append(
            Chart(
                key=letter,
                title="" if axis else "Nodal points, as measured",
                x_label=TIME,
                y_label=f"{letter}, mm",
                series=(*measured, *asked),
                bands=(background if not axis else _nameless(background)) if measured else (),
                wide=True,
            )
        )
    return charts


def _nameless(background: Sequence[Band]) -> tuple[Band, ...]:
    """Below a chart that names the bands."""
    return tuple(dataclasses.replace(band, label="") for band in background)


def _asked(trackings: Sequence[Tracking], number: int, axis: int) -> Array:
    """A coordinate of the place where the target's point of this number should have been; NaN where it leads fewer."""
    columns = [
        np.pad(tracking.desired_mm[..., axis], ((0, 0), (0, number + 1)), constant_values=np.nan)[:, number]
        for tracking in trackings
    ]
    return np.concatenate([np.zeros(0), *columns])


def _dashed(label: str, time_s: Array, values: Array) -> Series:
    return dataclasses.replace(over_time(label, time_s, values, -1), style="dashes")


def _travel(findings: Findings) -> Chart:
    """What each axis was told, in dashes, and what it did."""
    run = findings.run
    did = np.array([state.position_mm for state in run.tendons])
    told = np.array([[*command.displacement_mm, command.insertion_mm] for command in run.commands])
    did_s = [findings.second(state.time_ns) for state in run.tendons]
    told_s = [findings.second(command.time_ns) for command in run.commands]
    tendons = len(run.commands[0].displacement_mm) if run.commands else did.shape[-1] - 1
    axes = did.shape[1] if len(did) else told.shape[-1]
    return Chart(
        key="travel",
        title="Tendon pairs and stage",
        x_label=TIME,
        y_label="mm",
        series=(
            *(
                over_time(axis_name(axis, tendons), did_s, did[:, axis], axis)
                for axis in range(axes)
                if len(did)
            ),
            *(
                _dashed("command" if not axis else "", np.array(told_s), told[:, axis])
                for axis in range(axes)
                if len(told)
            ),
        ),
        bands=bands(findings.stretches, run.start_ns) if axes else (),
        wide=True,
    )


def _latency(findings: Findings) -> Chart:
    """From capture to each stage on the way, and how old the shapes were that the controller tracked with."""
    run = findings.run
    ages_ms = [1e3 * state.shape_age_s for state in run.states if state.state is State.TRACKING]
    durations = (
        ("capture to published shape", [shape.capture_to_publish_ns / 1e6 for shape in run.shapes], 2),
        ("capture to command", capture_to_command_ms(run), 0),
        ("age of the shape in use", ages_ms, 1),
    )
    return Chart(
        key="latency",
        title="Latency",
        x_label=DURATION,
        y_label="share, %",
        series=tuple(histogram(label, values, colour) for label, values, colour in durations if len(values)),
        logarithmic="x",
        wide=True,
    )
