"""What was found of all cameras, in words and in JSON. Pure."""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.suggestions import Suggestion
from nodal.cameras.judging.timing import Timing
from nodal.cameras.judging.verdicts import Finding, Verdict


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraReport:
    """One camera: the number of the picture that was looked at, when pictures came, what that means, what to set."""

    look: Look
    number: int
    timing: Timing | None
    findings: list[Finding]
    suggestions: list[Suggestion]


@dataclass(frozen=True, kw_only=True, eq=False)
class Report:
    """All cameras, and what was found of them `together`."""

    cameras: list[CameraReport]
    together: list[Finding]

    @property
    def suggestions(self) -> dict[str, list[Suggestion]]:
        """By camera, of those that have any."""
        return {camera.look.camera: camera.suggestions for camera in self.cameras if camera.suggestions}

    @property
    def is_poor(self) -> bool:
        """True when anything is."""
        findings = [finding for camera in self.cameras for finding in camera.findings] + self.together
        return any(finding.verdict is Verdict.POOR for finding in findings)


def as_words(report: Report, files: Sequence[Path]) -> str:
    """A line for each finding, with what to do below it; the settings that are suggested; where the pictures are."""
    return "\n".join(_lines(report, files))


def _lines(report: Report, files: Sequence[Path]) -> Iterator[str]:
    for camera in report.cameras:
        width, height = camera.look.size_px
        yield f"camera {camera.look.camera}, picture {camera.number}, {width}x{height} px"
        yield from _findings(camera.findings)
    if report.together:
        yield "cameras together"
        yield from _findings(report.together)
    if report.suggestions:
        yield "suggested for the bench file (--write puts it there)"
        for name, suggestions in report.suggestions.items():
            yield f"  [cameras.{name}.controls]"
            for suggestion in suggestions:
                yield f"  {suggestion.key} = {suggestion.value:g}  # {suggestion.reason}"
    yield "pictures: " + ", ".join(map(str, files))


def _findings(findings: Sequence[Finding]) -> Iterator[str]:
    for finding in findings:
        yield f"  {finding.verdict:<5} {finding.subject:<10} {finding.words}"
        if finding.advice:
            yield f"{'':18} -> {finding.advice}"


def as_json(report: Report) -> str:
    """Everything as one JSON object."""
    content = {
        "cameras": {camera.look.camera: _content(camera) for camera in report.cameras},
        "together": report.together,
    }
    return msgspec.json.format(msgspec.json.encode(content), indent=2).decode()


def _content(camera: CameraReport) -> Mapping[str, object]:
    return {
        "picture": camera.number,
        "size_px": camera.look.size_px,
        "figures": camera.look.figures(),
        "timing": None if camera.timing is None else dataclasses.asdict(camera.timing),
        "findings": camera.findings,
        "suggestions": camera.suggestions,
    }
