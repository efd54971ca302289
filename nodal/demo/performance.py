"""The demo from beginning to end: folder, processes, scenario, report."""

import json
import math
import sys
from pathlib import Path

import msgspec

from messaging.session import open_session
from nodal.bench_file import Bench, load_bench
from nodal.demo.folder import DemoFolder, make_demo_folder, processes_of
from nodal.demo.operator import Operator
from nodal.demo.progress import Progress
from nodal.demo.scenario import SHORTEST_S, Scenario
from nodal.demo.telemetry import Telemetry
from nodal.errors import CommandError, ReportError
from nodal.exit_status import INTERRUPTED
from nodal.processes.launcher import Launcher, Stopped
from nodal.running import stop_on_signals
from recordings.errors import RecordingError

LONGEST_S = 86_400.0
HOMED_WITHIN_S = 11.0
"""What starting and homing take besides, about."""


def perform(config: str, duration_s: float, out: Path | None, *, as_json: bool) -> int:
    """Run it; returns 0, or 130 when it was stopped before there was anything to report. Raises NodalError."""
    if not SHORTEST_S <= duration_s <= LONGEST_S or not math.isfinite(duration_s):
        raise CommandError(f"--duration {duration_s:g} s; allowed are {SHORTEST_S:g} to {LONGEST_S:g} s")
    stop = stop_on_signals()
    folder, bench = make_demo_folder(load_bench(config), out)
    scenario = Scenario.for_bench(bench.settings, duration_s)
    stopped = False
    with processes_of(folder, stop) as launcher:
        try:
            _close_the_loop(launcher, bench, scenario, folder)
        except Stopped:
            stopped = True
    return _report(folder, bench, stopped=stopped, as_json=as_json)


def _close_the_loop(launcher: Launcher, bench: Bench, scenario: Scenario, folder: DemoFolder) -> None:
    settings = bench.settings
    with open_session(settings.zenoh, settings.name, "demo") as session:
        telemetry = Telemetry(session)
        operator = Operator(session, launcher, telemetry)
        seconds = scenario.duration_s + HOMED_WITHIN_S
        with Progress(launcher, telemetry, _middle(bench), seconds) as progress:
            progress.say(f"demo in {folder.path}: starting the bench")

            def on_turn() -> None:
                telemetry.take()
                progress.show()

            launcher.on_turn = on_turn
            launcher.start()
            progress.say(f"{scenario.node} goes round a circle of {scenario.radius_mm:g} mm at 0.1 Hz")
            try:
                scenario.perform(operator, telemetry)
            finally:
                operator.relax()
            progress.say("done; tendons are relaxed")


def _middle(bench: Bench) -> str:
    half_mm = bench.settings.robot.length_mm / 2
    return min(bench.settings.sensing.nodal_points, key=lambda point: abs(point.arc_mm - half_mm)).name


def _report(folder: DemoFolder, bench: Bench, *, stopped: bool, as_json: bool) -> int:
    from nodal.report.writing import write_report  # noqa: PLC0415  slow, and nothing must be slow while the loop runs

    print("nodal: making the report", file=sys.stderr)
    try:
        summary = write_report(folder.path, folder.recording, bench)
    except (ReportError, RecordingError) as error:
        if not stopped:
            raise
        print(f"nodal: stopped before there was anything to report: {error}", file=sys.stderr)
        return INTERRUPTED
    text = msgspec.json.encode(summary).decode()
    if as_json:
        print(text)
    else:
        print(json.dumps(json.loads(text), indent=1), file=sys.stderr)
        print(folder.path)
    return 0
