"""From cameras to a report on them."""

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from drivers.cameras import (
    AviCameraSettings,
    CameraFrame,
    CameraSettings,
    FolderCameraSettings,
    V4l2CameraSettings,
    worst_skew_periods,
)
from drivers.cameras.v4l2.camera import V4l2Camera
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import BenchFile, read_bench
from nodal.calibration_file import load_rig
from nodal.cameras.chosen import chosen_cameras, running_cameras
from nodal.cameras.devices import device_at, held_controls, suggested_settings
from nodal.cameras.judging.measuring import look_at
from nodal.cameras.judging.report import CameraReport, Report
from nodal.cameras.judging.suggestions import section, suggestions_for
from nodal.cameras.judging.taking import take
from nodal.cameras.judging.timing import skews_s, timing_of
from nodal.cameras.judging.verdicts import (
    Finding,
    finding_on_size,
    finding_on_skew,
    finding_on_timing,
    findings_on,
)

SILENCE_S = 5.0
WITHOUT_CLOCK = AviCameraSettings, FolderCameraSettings
"""Files that do not say when each picture was taken."""


def look_at_device(arguments: argparse.Namespace) -> Report:
    """A camera that is on no bench, as `nodal cameras write` would set it up; raises CameraError."""
    device = device_at(arguments.device)
    settings = suggested_settings(device)
    with contextlib.closing(V4l2Camera("device", settings)) as camera:
        frames = take([camera], arguments.pictures, SILENCE_S)
    report = _report("device", settings, frames["device"], None)
    return Report(cameras=[dataclasses.replace(report, suggestions=[])], together=[])


def look_at_bench(arguments: argparse.Namespace) -> Report:
    """The cameras of a bench, or the files that stand for them; raises BenchFileError, CameraError, ProcessError."""
    bench = read_bench(arguments.config)
    chosen = chosen_cameras(arguments, bench.settings)
    with running_cameras(bench, chosen, "cameras") as (cameras, _):
        frames = take(cameras, arguments.pictures, SILENCE_S)
    sizes = _calibrated_sizes(bench)
    reports = [_report(name, chosen[name], frames[name], sizes.get(name)) for name in chosen]
    report = Report(cameras=reports, together=_together(bench, chosen, frames))
    if arguments.write and report.suggestions:
        edit_bench_file(bench.path, section(report.suggestions))
        print(f"{bench.path}: changed as suggested; {bench.path}~ is what it was", file=sys.stderr)
    return report


def _report(
    name: str, settings: CameraSettings, frames: Sequence[CameraFrame], calibrated_px: tuple[int, int] | None
) -> CameraReport:
    successive = frames[-1:] if isinstance(settings, FolderCameraSettings) else frames
    look = look_at(name, [frame.jpeg for frame in successive])
    findings = findings_on(look)
    timing = None if isinstance(settings, WITHOUT_CLOCK) else timing_of(frames)
    suggestions = []
    if isinstance(settings, V4l2CameraSettings):
        suggestions = suggestions_for(look, held_controls(settings.device), settings.rate_hz)
    if timing is not None:
        asked_hz = settings.rate_hz if isinstance(settings, V4l2CameraSettings) else None
        findings.append(finding_on_timing(timing, asked_hz))
    if calibrated_px is not None:
        findings.append(finding_on_size(look.size_px, calibrated_px, "its calibration"))
    return CameraReport(
        look=look,
        number=frames[-1].number,
        timing=timing,
        findings=findings,
        suggestions=suggestions,
    )


def _together(
    bench: BenchFile, chosen: Mapping[str, CameraSettings], frames: Mapping[str, Sequence[CameraFrame]]
) -> list[Finding]:
    if any(isinstance(settings, WITHOUT_CLOCK) for settings in chosen.values()):
        return []
    skews, timing = skews_s(frames), timing_of(next(iter(frames.values())))
    if not skews or timing is None:
        return []
    free_s = worst_skew_periods(len(frames)) / timing.rate_hz
    return [finding_on_skew(skews, bench.settings.sensing.maximum_skew_s, free_s)]


def _calibrated_sizes(bench: BenchFile) -> dict[str, tuple[int, int]]:
    """Width and height by camera, as far as the bench is calibrated already."""
    file = Path(bench.settings.calibration)
    rig = load_rig(file) if file.exists() else ()
    return {camera.camera: (camera.width_px, camera.height_px) for camera in rig}
