"""The figures of a run, as summary.json holds them. Pure."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from nodal.report.bench_run import BenchRun, times_ns
from nodal.report.statistics import mean, most, percentile, rounded
from nodal.report.tracking import true_tracking_of
from nodal.report.truth import TrueShapes

Array = NDArray[np.float64]

CIRCLE, HOLD = "demo-circle", "demo-hold"
"""Names of the demo's targets that figures are made of."""


class Spread(msgspec.Struct, frozen=True, kw_only=True):
    """Of distances."""

    mean: float | None
    p95: float | None
    max: float | None


class Percentiles(msgspec.Struct, frozen=True, kw_only=True):
    """Of durations."""

    p50: float | None
    p99: float | None


class TrackingFigures(msgspec.Struct, frozen=True, kw_only=True):
    """RMS distance of the true tip from where it should be: round the circle, and once a final hold has settled."""

    rms: float | None
    steady: float | None


class OpenLoopFigures(msgspec.Struct, frozen=True, kw_only=True):
    """RMS distance of the tip from the same circle without feedback."""

    rms: float | None


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """summary.json; docs/demo.md says how each figure is made. None where the run holds nothing to make it of."""

    frame_sets: int
    estimates: int
    estimate_rate_hz: float | None
    flagged: int
    node_error_mm: Spread
    tip_error_mm: Spread
    tracking_error_mm: TrackingFigures
    open_loop_error_mm: OpenLoopFigures
    capture_to_command_ms: Percentiles
    control_lateness_ms: Percentiles
    recording: str
    recording_losses: int


def summary_of(run: BenchRun, recording: str, open_loop_rms_mm: float | None) -> Summary:
    """Errors are against the truth at each estimate's capture time; raises ReportError when there is no truth."""
    truth = TrueShapes(run.truths)
    circle = true_tracking_of(run, truth, CIRCLE)
    hold = true_tracking_of(run, truth, HOLD).second_half()
    return Summary(
        frame_sets=run.frames.complete(),
        estimates=len(run.usable),
        estimate_rate_hz=rounded(estimate_rate_hz(run)),
        flagged=sum(bool(shape.flags) for shape in run.usable),
        node_error_mm=_spread(np.linalg.norm(_all(node_offsets_mm(run, truth)), axis=1)),
        tip_error_mm=_spread(tip_errors_mm(run, truth)),
        tracking_error_mm=TrackingFigures(rms=rounded(circle.rms_mm()), steady=rounded(hold.rms_mm())),
        open_loop_error_mm=OpenLoopFigures(rms=rounded(open_loop_rms_mm)),
        capture_to_command_ms=_percentiles(capture_to_command_ms(run)),
        control_lateness_ms=_percentiles(lateness_ms(run)),
        recording=recording,
        recording_losses=run.losses,
    )


def estimate_rate_hz(run: BenchRun) -> float | None:
    """Usable estimates over the time between the first and the last; None for fewer than two."""
    captured = times_ns(run.usable)
    span_ns = int(np.ptp(captured)) if len(captured) else 0
    return (len(captured) - 1) / span_ns * 1e9 if span_ns else None


def capture_to_command_ms(run: BenchRun) -> Array:
    """(N,) from the capture of a frame set to the first command written that used it."""
    ages_ns = [
        command.capture_to_command_ns for command in run.commands if command.capture_to_command_ns >= 0
    ]
    return np.array(ages_ns) / 1e6


def lateness_ms(run: BenchRun) -> Array:
    """(N,) how late the controller's cycles began."""
    return np.array([state.lateness_s for state in run.states]) * 1e3


def node_offsets_mm(run: BenchRun, truth: TrueShapes) -> list[Array]:
    """For each estimate that the truth covers, where its nodal points lie from the truth at its capture (M, 3)."""
    return [
        shape.node_mm - truth.points_mm(times_ns([shape]), shape.node_arc_mm)[0]
        for shape in run.covered(truth)
    ]


def tip_errors_mm(run: BenchRun, truth: TrueShapes) -> Array:
    """(N,) the same for the end of the centreline."""
    shapes = run.covered(truth)
    ends = np.array([shape.centreline_mm[-1] for shape in shapes]).reshape(-1, 3)
    return np.asarray(np.linalg.norm(ends - truth.centrelines_mm(times_ns(shapes))[:, -1], axis=1))


def _all(offsets_mm: list[Array]) -> Array:
    return np.concatenate([np.zeros((0, 3)), *offsets_mm])


def _spread(values: Array) -> Spread:
    return Spread(mean=mean(values), p95=percentile(values, 95), max=most(values))


def _percentiles(values: Array) -> Percentiles:
    return Percentiles(p50=percentile(values, 50), p99=percentile(values, 99))
