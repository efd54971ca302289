"""The figures of a run, as summary.json holds them. Pure."""

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from nodal.report.bench_run import BenchRun, times_ns
from nodal.report.tracking import tracking_of
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
    nodes, tips = estimate_errors_mm(run, truth)
    circle = tracking_of(run, truth, CIRCLE)
    hold = tracking_of(run, truth, HOLD).second_half()
    capture_to_command = [c.capture_to_command_ns for c in run.commands if c.capture_to_command_ns >= 0]
    captured = times_ns(run.usable)
    span_s = (captured[-1] - captured[0]) / 1e9 if len(captured) > 1 else 0.0
    return Summary(
        frame_sets=run.frames.complete(),
        estimates=len(run.usable),
        estimate_rate_hz=_rounded((len(captured) - 1) / span_s) if span_s else None,
        flagged=sum(bool(shape.flags) for shape in run.usable),
        node_error_mm=_spread(nodes),
        tip_error_mm=_spread(tips),
        tracking_error_mm=TrackingFigures(rms=_rounded(circle.rms_mm()), steady=_rounded(hold.rms_mm())),
        open_loop_error_mm=OpenLoopFigures(rms=_rounded(open_loop_rms_mm)),
        capture_to_command_ms=_percentiles(np.array(capture_to_command) / 1e6),
        control_lateness_ms=_percentiles(np.array([state.lateness_s for state in run.states]) * 1e3),
        recording=recording,
        recording_losses=run.losses,
    )


def estimate_errors_mm(run: BenchRun, truth: TrueShapes) -> tuple[Array, Array]:
    """Distances of all nodal points (K,), and of the tip (N,), of every estimate from the truth when it was captured."""
    shapes = run.usable
    time_ns = times_ns(shapes)
    covered = truth.covers(time_ns) if len(time_ns) else np.zeros(0, bool)
    nodes, tips = [np.zeros(0)], []
    for shape, known in zip(shapes, covered, strict=True):
        if known:
            at = time_ns[:1] * 0 + shape.capture_time_ns
            true_nodes = truth.points_mm(at, shape.node_arc_mm)[0]
            nodes.append(np.linalg.norm(shape.node_mm - true_nodes, axis=1))
            tips.append(np.linalg.norm(shape.centreline_mm[-1] - truth.centrelines_mm(at)[0, -1]))
    return np.concatenate(nodes), np.array(tips)


def _spread(values: Array) -> Spread:
    if not values.size:
        return Spread(mean=None, p95=None, max=None)
    return Spread(
        mean=_rounded(values.mean()), p95=_rounded(np.percentile(values, 95)), max=_rounded(values.max())
    )


def _percentiles(values: Array) -> Percentiles:
    if not values.size:
        return Percentiles(p50=None, p99=None)
    return Percentiles(p50=_rounded(np.percentile(values, 50)), p99=_rounded(np.percentile(values, 99)))


def _rounded(value: ArrayLike | None) -> float | None:
    return None if value is None else round(float(np.asarray(value)), 4)
