"""What every step of calibration ends with: the report made anew, and the step that follows."""

from pathlib import Path

from messaging.errors import NodalError
from nodal.bench_file import BenchFile
from nodal.calibrate.report.page import write_report

FOLLOWED_BY = {"cameras": "base", "base": "background", "background": "robot"}


def report_anew(bench: BenchFile) -> str:
    """Where the report is; calibration does without one too, and then this says why there is none."""
    try:
        return str(write_report(bench))
    except NodalError as error:
        return f"not written: {error}"


def next_step(bench: BenchFile, done: str) -> str:
    """What to do after this step."""
    if done == "background" and not Path(bench.settings.calibration).exists():
        done = "cameras"  # the robot frame is still to be found, and the work area after it
    if done in FOLLOWED_BY:
        return f"next: nodal calibrate {FOLLOWED_BY[done]} --config {bench.path}"
    if bench.settings.simulation is not None:
        return f"next: nodal demo --config {bench.path}"
    return f"next: start the bench's processes (docs/operation.md), then nodal do home --config {bench.path}"
