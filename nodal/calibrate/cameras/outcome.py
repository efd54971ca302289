"""What `nodal calibrate cameras` comes to, for people and for programs."""

import dataclasses
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from calibration.camera_set import CameraSet
from nodal.bench_file import BenchFile
from nodal.calibrate.cameras.geometry import moved
from nodal.calibrate.cameras.verdict import judgements, overall
from nodal.calibrate.cameras.words import SUMMARIES, aligned, camera_rows, hint, places, value_of
from nodal.calibrate.ending import next_step

MOST_REASONS = 6


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """The cameras, where they and the report lie, how many looks were not taken as views and why, and what the calibration file
    knew of the cameras so far.
    """

    bench: BenchFile
    cameras: CameraSet
    file: Path
    report: str
    refused: Counter[str]
    before: CameraSet | None


def as_text(outcome: Outcome) -> str:
    """Tables, verdict, what was left out, and what comes next."""
    cameras = outcome.cameras
    found = judgements(cameras)
    return "\n".join(
        [
            *aligned(camera_rows(cameras)),
            "",
            *places(cameras),
            "",
            *aligned([(one.grade, one.what, value_of(one), hint(one)) for one in found]),
            "",
            f"verdict: {SUMMARIES[overall(found)]}",
            *_left_out(outcome),
            "",
            f"written: {outcome.file}",
            f"report:  {outcome.report}",
            *_next(outcome),
        ]
    )


def as_builtins(outcome: Outcome) -> dict[str, Any]:
    """The same as one JSON object."""
    cameras = outcome.cameras
    found = judgements(cameras)
    return {
        "cameras": msgspec.to_builtins(cameras),
        "verdict": str(overall(found)),
        "judgements": [
            {"what": one.what, "value": one.value, "unit": one.unit, "grade": str(one.grade)} for one in found
        ],
        "not_taken": dict(outcome.refused),
        "moved": msgspec.to_builtins(list(moved(outcome.before, cameras))),
        "file": str(outcome.file),
        "report": outcome.report,
    }


def _left_out(outcome: Outcome) -> Iterator[str]:
    if missing := outcome.cameras.missing:
        yield ""
        yield from (f"missing: {words}" for words in missing)
    if rejected := outcome.cameras.views_rejected:
        yield ""
        yield from (f"view {name} rejected: {reason}" for name, reason in rejected.items())
    if outcome.refused:
        yield ""
        for reason, count in outcome.refused.most_common(MOST_REASONS):
            yield f"not taken ({count}): {reason}"


def _next(outcome: Outcome) -> Iterator[str]:
    for one in moved(outcome.before, outcome.cameras):
        yield (
            f"in {outcome.bench.settings.calibration} camera {one.camera} stands {one.shift_mm:.2f} mm and "
            f"{one.turn_deg:.3f} degrees elsewhere, as seen from camera {outcome.cameras.cameras[0].name}"
        )
    if outcome.before is not None:
        yield "that file is as it was: the bench runs with it until the robot frame was found again"
    yield next_step(outcome.bench, "cameras")
