"""Writes a run's summary.json and its pictures."""

import dataclasses
import logging
import time
from pathlib import Path

import msgspec
import numpy as np

from messaging.shape import NodalPoints, ShapeEstimate
from nodal.bench_file import Bench
from nodal.errors import ReportError
from nodal.report.bench_run import BenchRun
from nodal.report.findings import Findings
from nodal.report.loading import attached_rig, frame_set, load_run
from nodal.report.open_loop import open_loop_path
from nodal.report.pictures.estimate.writing import draw_estimate
from nodal.report.pictures.run import draw_run
from nodal.report.summary import CIRCLE, Summary, summary_of
from nodal.report.tracking import Tracking, true_tracking_of
from nodal.report.truth import TrueShapes
from recordings import Log
from sensing.errors import SensingError
from sensing.method import bench_method

logger = logging.getLogger(__name__)

OPEN_LOOP_S = 20.0
CANDIDATES_APART = 97
"""Frame sets between two that are tried for a picture of the stages, in the order of their bend."""


def write_report(folder: Path, recording: Path, bench: Bench) -> Summary:
    """From the recording of this simulated bench; raises ReportError, RecordingError, NodalError without matplotlib."""
    log = Log(recording)
    run = load_run(log)
    if not run.rig:
        raise ReportError(f"{recording}: {attached_rig(log)[1]}")
    truth = TrueShapes(run.truths)
    circle = true_tracking_of(run, truth, CIRCLE)
    without_feedback = _without_feedback(circle, bench)
    summary = summary_of(run, recording.name, without_feedback.rms_mm() if without_feedback else None)
    (folder / "summary.json").write_bytes(msgspec.json.format(msgspec.json.encode(summary), indent=1) + b"\n")
    draw_run(folder, Findings(run), circle, without_feedback)
    _draw_one_estimate(folder, log, run, bench)
    return summary


def _without_feedback(circle: Tracking, bench: Bench) -> Tracking | None:
    """What the circle of this run would have been in open loop; None when there was no circle."""
    if len(circle.time_ns) < 2 or bench.settings.simulation is None:
        return None
    # the circle repeats itself, so its first rounds tell all
    circle = circle.first(OPEN_LOOP_S)
    reached_mm = open_loop_path(
        circle.desired_mm,
        (circle.time_ns - circle.time_ns[0]) / 1e9,
        circle.arc_mm[0],
        bench.settings.controller.kinematics(bench.settings.robot),
        bench.settings.simulation.robot,
    )
    return dataclasses.replace(circle, reached_mm=reached_mm)


def _draw_one_estimate(folder: Path, log: Log, run: BenchRun, bench: Bench) -> None:
    """The stages of one frame set, found anew without a prior: the more a shape is bent, the more it shows."""
    method = bench_method(bench.settings.sensing, bench.settings.robot, run.rig, bench.backgrounds)
    for shape in sorted(run.usable, key=_sideways_mm, reverse=True)[::CANDIDATES_APART]:
        jpegs = {name: frame.jpeg for name, frame in frame_set(log, shape.capture_time_ns).items()}
        try:
            pictures = {name: method.scene.picture(name, jpeg) for name, jpeg in jpegs.items()}
            found = method.estimate(pictures, shape.insertion_mm, None, time.perf_counter)
        except SensingError as error:
            logger.info("no picture of frame set %d: %s", shape.sequence, error)
            continue
        nodes = NodalPoints(names=shape.node_names, arc_mm=shape.node_arc_mm)
        draw_estimate(folder, method, jpegs, found, nodes)
        return
    raise ReportError(f"{log.path}: no frame set could be estimated anew for the pictures of its stages")


def _sideways_mm(shape: ShapeEstimate) -> float:
    return float(np.linalg.norm(shape.centreline_mm[-1, :2]))
