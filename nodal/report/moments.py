"""The moments of a run that are worth a picture. Pure."""

import dataclasses
from collections.abc import Iterator

import numpy as np

from messaging.shape import ShapeEstimate
from nodal.report.findings import Findings
from nodal.report.tracking import Tracking


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """A frame set, and why it is shown; `asked_mm` (M, 3) are the places where nodal points should have been then."""

    shape: ShapeEstimate
    titles: tuple[str, ...]
    asked_mm: np.ndarray


def telling_moments(findings: Findings) -> list[Moment]:
    """In order of time; a frame set with several things to tell stands there once."""
    shapes = findings.run.shapes
    captures_ns = np.array([shape.capture_time_ns for shape in shapes])
    titles: dict[int, list[str]] = {}
    for title, time_ns in _told(findings) if shapes else ():
        # the newest frame set that was captured by then
        index = max(int(np.searchsorted(captures_ns, time_ns, side="right")) - 1, 0)
        titles.setdefault(index, []).append(title)
    asked = _asked(findings)
    return [
        Moment(
            shape=shapes[index],
            titles=tuple(told),
            asked_mm=asked.get(shapes[index].capture_time_ns, np.zeros((0, 3))),
        )
        for index, told in sorted(titles.items())
    ]


def _told(findings: Findings) -> Iterator[tuple[str, int]]:
    """What is worth telling, and when it was (Unix ns)."""
    run = findings.run
    if run.usable:
        yield "the first estimate", run.usable[0].capture_time_ns
    yield from _worst_tracking(findings)
    yield from _worst_estimate(findings)
    if flagged := next((shape for shape in run.usable if shape.flags), None):
        yield f"the first flag: {', '.join(flagged.flags)}", flagged.capture_time_ns
    if refused := next((shape for shape in run.shapes if shape.refusal), None):
        yield f"the first refusal: {refused.refusal}", refused.capture_time_ns
    for kind, found in (("hold", findings.waits), ("fault", findings.faults)):
        if found:
            yield f"the first {kind}: {found[0].reason}", found[0].begin_ns
    yield "the last frame set", run.shapes[-1].capture_time_ns


def _worst_estimate(findings: Findings) -> Iterator[tuple[str, int]]:
    run = findings.run
    largest = [errors.max(initial=0) for errors in findings.node_errors_mm]
    if largest and run.truth:
        worst = run.covered(run.truth)[int(np.argmax(largest))]
        yield (
            f"the largest error of an estimate, {max(largest):.3f} mm from the truth",
            worst.capture_time_ns,
        )


def _worst_tracking(findings: Findings) -> Iterator[tuple[str, int]]:
    def largest(tracking: Tracking) -> float:
        return float(tracking.error_mm.max(initial=0))

    known = {label: tracking for label, tracking in findings.tracking.items() if tracking.error_mm.size}
    if not known:
        return
    label = max(known, key=lambda name: largest(known[name]))
    row = int(known[label].error_mm.max(axis=1).argmax())
    yield f"furthest from {label}, {largest(known[label]):.2f} mm", int(known[label].time_ns[row])


def _asked(findings: Findings) -> dict[int, np.ndarray]:
    """By capture time."""
    return {
        time_ns: places
        for tracking in findings.measured.values()
        for time_ns, places in zip(tracking.time_ns.tolist(), tracking.desired_mm, strict=True)
    }
