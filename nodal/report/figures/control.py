"""Figures of the controller and the tendons."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from controller.limits import axis_name
from messaging.control import State
from nodal.report.bench_run import BenchRun
from nodal.report.figures.model import Chapter, Figure, Group, durations, figures
from nodal.report.findings import Findings
from nodal.report.statistics import least, most, percentile, rms
from nodal.report.stretches import seconds_in
from nodal.report.summary import capture_to_command_ms, lateness_ms
from nodal.report.tracking import Tracking

Array = NDArray[np.float64]

LARGEST_STEP_NS = 500_000_000


def control(findings: Findings) -> tuple[Chapter, ...]:
    """Tracking, states, latencies, the loop's timing, tendons; what there is of it."""
    run = findings.run
    chapters = []
    if findings.pursuits:
        chapters.append(_tracking(findings))
    if run.states:
        chapters.append(_states(findings))
    if run.shapes or run.commands:
        chapters.append(_latencies(run))
    if run.states:
        chapters.append(_loop(run))
    if run.tendons:
        chapters.append(_tendons(run))
    return tuple(chapters)


def _tracking(findings: Findings) -> Chapter:
    groups = []
    for pursuit in findings.pursuits:
        measured, true = findings.measured[pursuit.label], findings.true.get(pursuit.label)
        followed = pursuit.followed_s / pursuit.duration_s if pursuit.duration_s else None
        groups.append(
            Group(
                pursuit.label,
                (
                    *figures(
                        pursued_s=("pursued", pursuit.duration_s),
                        waiting_percent=(
                            "not tracking",
                            None if followed is None else 100 * (1 - followed),
                        ),
                        captures=("captures", len(measured.time_ns)),
                    ),
                    *_distances("measured", measured),
                    *(_distances("true", true) if true else ()),
                ),
            )
        )
    return Chapter("tracking", "Tracking", tuple(groups))


def _distances(kind: str, tracking: Tracking) -> tuple[Figure, ...]:
    errors = tracking.error_mm
    return figures(
        **{
            f"{kind}_rms_mm": (f"{kind}, RMS", rms(errors)),
            f"{kind}_p95_mm": (f"{kind}, 95 % below", percentile(errors, 95)),
            f"{kind}_max_mm": (f"{kind}, largest", most(errors)),
        }
    )


def _states(findings: Findings) -> Chapter:
    waits, faults = findings.waits, findings.faults
    return Chapter(
        "states",
        "States of the controller",
        (
            Group(
                "time in",
                figures(
                    **{f"{state}_s": (str(state), seconds_in(findings.stretches, state)) for state in State}
                ),
            ),
            Group(
                "interruptions",
                figures(
                    holds=("holds that nobody asked for", len(waits)),
                    holding_s=("in such holds", sum(wait.duration_s for wait in waits)),
                    longest_hold_s=("longest of them", most([wait.duration_s for wait in waits])),
                    faults=("faults", len(faults)),
                    restarts=("restarts of processes", len(findings.run.restarts)),
                ),
            ),
        ),
    )


def _latencies(run: BenchRun) -> Chapter:
    published = [shape.capture_to_publish_ns / 1e6 for shape in run.shapes]
    sighted = [1e3 * state.sighted_age_s for state in run.states if state.sighted_capture_ns]
    groups: dict[str, ArrayLike] = {
        "capture to estimate published": published,
        "capture to estimate seen by the controller": sighted,
        "capture to command": capture_to_command_ms(run),
    }
    return Chapter(
        "latency",
        "Latencies",
        tuple(Group(title, durations(times)) for title, times in groups.items() if np.size(times)),
    )


def _loop(run: BenchRun) -> Chapter:
    step_ns = np.diff([state.time_ns for state in run.states])
    steady_ns = step_ns[(step_ns > 0) & (step_ns < LARGEST_STEP_NS)]
    return Chapter(
        "loop",
        "Timing of the control loop",
        (
            Group("lateness of a cycle", durations(lateness_ms(run))),
            Group("work in a cycle", durations([1e3 * state.busy_s for state in run.states])),
            Group("from cycle to cycle", durations(steady_ns / 1e6)),
            Group(
                "cycles",
                figures(
                    cycles=("cycles", len(run.states)),
                    rate_hz=("rate", 1e9 / steady_ns.mean() if len(steady_ns) else None),
                    overruns=("missed", _overruns(run)),
                    undriven=(
                        "without a reading of the servos",
                        sum(bool(s.drive_absence) for s in run.states),
                    ),
                ),
            ),
        ),
    )


def _overruns(run: BenchRun) -> int:
    """Deadlines missed since the recording began; a controller that begins anew counts from 0 again."""
    counts = np.array([state.overruns for state in run.states])
    return int(np.diff(counts).clip(min=0).sum())


def _tendons(run: BenchRun) -> Chapter:
    """Of each tendon pair and the stage: what was asked, what was reached, and how its servo fared."""
    reached = np.array([state.position_mm for state in run.tendons])
    tendons = len(run.tendons[0].displacement_mm)
    errors = (
        reached - _asked_before(run)[:, : reached.shape[1]]
        if run.commands
        else np.zeros((0, reached.shape[1]))
    )
    errors = errors[np.isfinite(errors).all(axis=1)]
    axes = reached.shape[1]
    servos = {
        "current_ma": np.array([state.current_ma for state in run.tendons]),
        "temperature_c": np.array([state.temperature_c for state in run.tendons]),
        "voltage_v": np.array([state.voltage_v for state in run.tendons]),
        "hardware_error": np.array([state.hardware_error for state in run.tendons]),
    }
    return Chapter(
        "tendons",
        "Tendons and stage",
        tuple(
            Group(
                axis_name(axis, tendons),
                figures(
                    least_mm=("least", least(reached[:, axis])),
                    most_mm=("most", most(reached[:, axis])),
                    following_rms_mm=("behind the command, RMS", rms(errors[:, axis])),
                    current_rms_ma=("current, RMS", rms(servos["current_ma"][:, axis])),
                    current_max_ma=("current, largest", most(np.abs(servos["current_ma"][:, axis]))),
                    temperature_c=("hottest", most(servos["temperature_c"][:, axis])),
                    voltage_min_v=("lowest voltage", least(servos["voltage_v"][:, axis])),
                    alarms=("readings with an alarm", np.count_nonzero(servos["hardware_error"][:, axis])),
                ),
            )
            for axis in range(axes)
        ),
        minor=True,
    )


def _asked_before(run: BenchRun) -> Array:
    """For each reading of the servos, the axes' newest command before it (N, A); NaN where there was none lately."""
    asked = np.array([[*command.displacement_mm, command.insertion_mm] for command in run.commands])
    asked_ns = np.array([command.time_ns for command in run.commands])
    read_ns = np.array([state.time_ns for state in run.tendons])
    # a cycle reads the servos before it commands them, so what it reads answers the command before
    before = np.searchsorted(asked_ns, read_ns, side="left") - 1
    answered = (before >= 0) & (read_ns - asked_ns[before] < LARGEST_STEP_NS)
    return np.where(answered[:, None], asked[before], np.nan)
