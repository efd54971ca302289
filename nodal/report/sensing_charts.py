"""The charts of what sensing said in a run. Pure."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from nodal.report.bench_run import times_ns
from nodal.report.charts import FLOOR_MM, TIME, Chart, a_second, bands, line, over_time
from nodal.report.findings import Findings


def errors(findings: Findings) -> Iterable[Chart]:
    errors = findings.node_errors_mm
    yield Chart(
        key="estimate-error",
        title="Error of the estimates against the truth",
        x_label=TIME,
        y_label="distance, mm",
        series=(
            over_time(
                "worst nodal point", findings.error_time_s, [row.max(initial=FLOOR_MM) for row in errors], 1
            ),
            over_time("mean of nodal points", findings.error_time_s, [row.mean() for row in errors], 0),
        ),
        logarithmic="y",
        bands=bands(findings.stretches, findings.run.start_ns),
        wide=True,
    )


def quality(findings: Findings) -> Iterable[Chart]:
    usable = findings.run.usable
    time_s = findings.since_start_s(times_ns(usable))
    known_mm = [shape.known_length_mm or np.nan for shape in usable]
    sigma_mm = [sigmas.max(initial=0) for sigmas in findings.sigmas_mm]

    def chart(key: str, title: str, unit: str, *lines: tuple[str, ArrayLike]) -> Chart:
        series = tuple(
            over_time(label, time_s, values, number) for number, (label, values) in enumerate(lines)
        )
        return Chart(key=key, title=title, x_label=TIME, y_label=unit, series=series)

    yield chart("residual", "Reprojection residual", "px", ("all cameras", [s.residual_px for s in usable]))
    yield chart(
        "ray-gap",
        "Gap between paired rays",
        "mm",
        ("mean", [shape.ray_gap_mm for shape in usable]),
        ("bias", [shape.ray_bias_mm for shape in usable]),
    )
    known = [("known", known_mm)] if np.isfinite(known_mm).any() else []
    yield chart("length", "Length", "mm", ("measured", [shape.length_mm for shape in usable]), *known)
    yield chart("sigma", "Largest standard deviation of a nodal point", "mm", ("estimates", sigma_mm))
    yield chart(
        "epipolar",
        "Smallest angle to the epipolar direction",
        "degrees",
        ("estimates", findings.epipolar_deg),
    )


def cameras(findings: Findings) -> Iterable[Chart]:
    time_s = findings.since_start_s(times_ns(findings.run.usable))
    for key, title, unit, values in (
        (
            "camera-residual",
            "Residual in each camera",
            "px",
            findings.by_camera(lambda s: s.camera_residual_px),
        ),
        ("visible", "Length that each camera sees", "mm", findings.by_camera(lambda s: s.visible_mm)),
    ):
        yield Chart(
            key=key,
            title=title,
            x_label=TIME,
            y_label=unit,
            series=tuple(
                over_time(name, time_s, told, number) for number, (name, told) in enumerate(values.items())
            ),
        )


def sensing(findings: Findings) -> Iterable[Chart]:
    captured_s = findings.since_start_s(times_ns(findings.run.usable))
    yield Chart(
        key="estimates-a-second",
        title="Estimates in each second",
        x_label=TIME,
        y_label="estimates",
        series=(a_second("estimates", captured_s),),
    )
    yield Chart(
        key="estimating",
        title="Time that an estimate takes",
        x_label=TIME,
        y_label="all stages, ms",
        series=(over_time("estimates", captured_s, [1e3 * s.stage_s.sum() for s in findings.run.usable]),),
        logarithmic="y",
    )
    yield _flags(findings)


def _flags(findings: Findings) -> Chart:
    """Each flag where it was raised, the most frequent at the top."""
    names = [name for name, _ in reversed(findings.flags.most_common())]
    raised_s = {
        name: [findings.second(s.capture_time_ns) for s in findings.run.usable if name in s.flags]
        for name in names
    }
    return Chart(
        key="flags",
        title="Flags",
        x_label=TIME,
        y_label="",
        series=tuple(
            line(name, raised_s[name], np.full(len(raised_s[name]), row), 1, "ticks")
            for row, name in enumerate(names)
        ),
        rows=tuple(names),
        wide=True,
    )
