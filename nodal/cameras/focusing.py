"""`nodal cameras look --focus`: where webcams' lenses are sharpest."""

import argparse
import contextlib
import math
import statistics
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from drivers.cameras import V4l2CameraSettings
from drivers.cameras.v4l2.camera import V4l2Camera
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import BenchFile, read_bench
from nodal.cameras.devices import device_at, suggested_settings
from nodal.cameras.judging.focus import sharpest, sweep
from nodal.cameras.judging.sharpness import edges_in
from nodal.cameras.judging.taking import take
from nodal.cameras.judging.verdicts import Finding, Verdict, finding_on_sharpness
from nodal.cameras.looking import SILENCE_S
from nodal.errors import CommandError
from nodal.exit_status import REFUSED
from sensing.pictures.picture import Picture

PICTURES = 3


@dataclass(frozen=True, kw_only=True)
class Focusing:
    """Edge widths in px by focus, infinite where there were no edges; the focus `before`, and the sharpest."""

    camera: str
    before: int
    best: int
    widths_px: Mapping[int, float]

    @property
    def finding(self) -> Finding:
        """What the sharpest is like."""
        width_px = self.widths_px[self.best]
        return finding_on_sharpness(None if math.isinf(width_px) else width_px)


def look_for_focus(arguments: argparse.Namespace) -> int:
    """Sweep, tell, write; 0, or 3 when a camera is blurred at any focus.

    Each camera is left at its sharpest. Raises BenchFileError, CameraError, and CommandError where no camera has a focus.
    """
    found = [_focused(name, settings) for name, settings in _with_focus(arguments).items()]
    sharp = [one for one in found if one.finding.verdict is not Verdict.POOR]
    print(_json(found) if arguments.json else "\n".join(map(_words, found)))
    if arguments.write and sharp:
        _write(read_bench(arguments.config), sharp)
    return 0 if len(sharp) == len(found) else REFUSED


def _with_focus(arguments: argparse.Namespace) -> dict[str, V4l2CameraSettings]:
    """The device, or the bench's webcams; those whose focus cannot be set are said and left out."""
    if arguments.device:
        chosen = {"device": suggested_settings(device_at(arguments.device))}
    else:
        cameras = read_bench(arguments.config).settings.cameras
        chosen = {name: one for name, one in cameras.items() if isinstance(one, V4l2CameraSettings)}
    having = {
        name: settings
        for name, settings in chosen.items()
        if any(control.setting == "focus" for control in device_at(settings.device).controls)
    }
    for name in chosen.keys() - having.keys():
        print(f"camera {name}: it has no focus that can be set; turn its lens by hand", file=sys.stderr)
    if not having:
        raise CommandError("--focus: none of the cameras is a webcam with a focus that can be set")
    return having


def _write(bench: BenchFile, found: Sequence[Focusing]) -> None:
    edit_bench_file(bench.path, {"cameras": {one.camera: {"controls": {"focus": one.best}} for one in found}})
    print(f"{bench.path}: each focus set; {bench.path}~ is what it was", file=sys.stderr)
    if Path(bench.settings.calibration).exists():
        print("The calibration holds for the focus before: nodal calibrate cameras", file=sys.stderr)


def _focused(name: str, settings: V4l2CameraSettings) -> Focusing:
    control = next(control for control in device_at(settings.device).controls if control.setting == "focus")

    def width_px(focus: int) -> float:
        width_px = _width_px(name, settings, focus)
        print(f"camera {name}: focus {focus:>4}: {_wide(width_px)}", file=sys.stderr)
        return width_px

    before = {control.value: width_px(control.value)}
    tried = before | sweep(width_px, control.minimum, control.maximum, control.step)
    best = sharpest(tried)
    return Focusing(camera=name, before=control.value, best=best, widths_px=tried | {best: width_px(best)})


def _width_px(name: str, settings: V4l2CameraSettings, focus: int) -> float:
    """Of a few pictures at this focus; the camera stays there."""
    controls = msgspec.structs.replace(settings.controls, focus=focus)
    at_focus = msgspec.structs.replace(settings, controls=controls)
    with contextlib.closing(V4l2Camera(name, at_focus)) as camera:
        frames = take([camera], PICTURES, SILENCE_S)[name]
    size_px = settings.width_px, settings.height_px
    widths_px = (edges_in(Picture(name, frame.jpeg, size_px).luma).width_px for frame in frames)
    return statistics.median(math.inf if width_px is None else width_px for width_px in widths_px)


def _wide(width_px: float) -> str:
    return "no edges" if math.isinf(width_px) else f"edges are {width_px:.1f} px wide"


def _words(found: Focusing) -> str:
    finding = found.finding
    before = f"at {found.before}, where it was, {_wide(found.widths_px[found.before])}"
    lines = [f"camera {found.camera}: {finding.words}, at focus {found.best}; {before}"]
    if finding.advice:
        lines.append(f"  -> {finding.advice}")
    if finding.verdict is not Verdict.POOR:
        lines += [f"  [cameras.{found.camera}.controls]", f"  focus = {found.best}"]
    return "\n".join(lines)


def _json(found: list[Focusing]) -> str:
    content = {
        one.camera: {
            "focus": one.best,
            "focus_before": one.before,
            "verdict": one.finding.verdict,
            "edge_widths_px": {
                str(focus): None if math.isinf(width_px) else width_px
                for focus, width_px in sorted(one.widths_px.items())
            },
        }
        for one in found
    }
    return msgspec.json.format(msgspec.json.encode(content), indent=2).decode()
