"""A run in two sentences: what it did, and what is to be said against it. Pure."""

import dataclasses
from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from nodal.report.findings import Findings
from nodal.report.stretches import without_numbers
from nodal.report.summary import estimate_rate_hz


class Level(StrEnum):
    """How a run fared."""

    GOOD = "good"
    """Nothing to be said against it."""
    REMARKS = "remarks"
    """It went on by itself, and somebody should look."""
    BAD = "bad"
    """It faulted, or part of the recording cannot be read."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verdict:
    """Two sentences and how serious the second is."""

    level: Level
    done: str
    wrong: str


def verdict(findings: Findings, damage: Sequence[str], *, finished: bool) -> Verdict:
    """Of a run whose recording has this damage, and was `finished` by its recorder or cut off."""
    serious = _serious(findings, damage)
    remarks = _remarks(findings, finished=finished)
    level = Level.BAD if serious else Level.REMARKS if remarks else Level.GOOD
    found = [*serious, *remarks]
    wrong = _sentence(found) if found else "There was no fault, no hold, no refusal, and nothing is missing."
    return Verdict(level=level, done=_sentence([_done(findings)]), wrong=wrong)


def _done(findings: Findings) -> str:
    run = findings.run
    if not run.traffic:
        return "the recording holds no publication"
    length = f"in {(run.end_ns - run.start_ns) / 1e9:.1f} s"
    return f"{length}, {_sensed(findings)}, and {_tracked(findings)}"


def _sensed(findings: Findings) -> str:
    run = findings.run
    if not run.usable:
        return "no shape estimated"
    rate_hz = estimate_rate_hz(run)
    more = [f"{rate_hz:.1f} Hz"] if rate_hz else []
    if findings.node_errors_mm:
        more.append(f"{np.concatenate(findings.node_errors_mm).mean():.3f} mm from the truth on average")
    return f"{_count(len(run.usable), 'shape')} estimated" + (f" ({'; '.join(more)})" if more else "")


def _tracked(findings: Findings) -> str:
    followed = [tracking for tracking in findings.tracking.values() if len(tracking.time_ns)]
    if not followed:
        return "no target tracked"
    distances = np.concatenate([tracking.error_mm.ravel() for tracking in followed])
    seconds = sum(pursuit.followed_s for pursuit in findings.pursuits)
    return (
        f"{_count(len(followed), 'target')} tracked for {seconds:.1f} s, "
        f"{np.sqrt((distances**2).mean()):.2f} mm RMS off {'in truth' if findings.true else 'as measured'}"
    )


def _serious(findings: Findings, damage: Sequence[str]) -> list[str]:
    found = []
    if faults := findings.faults:
        found.append(
            f"{_count(len(faults), 'fault')}, the first after {_first(findings, faults[0].begin_ns)}: {faults[0].reason}"
        )
    if damage:
        found.append(f"the recording is damaged in {_count(len(damage), 'place')}")
    return found


def _remarks(findings: Findings, *, finished: bool) -> list[str]:
    run, waits = findings.run, findings.waits
    flagged, refused = sum(bool(shape.flags) for shape in run.usable), len(run.shapes) - len(run.usable)
    found = []
    if waits:
        seconds = sum(wait.duration_s for wait in waits)
        kind = without_numbers(max(waits, key=lambda wait: wait.duration_s).reason)
        found.append(
            f"the controller held by itself {_count(len(waits), 'time')}, {seconds:.2f} s in all ({kind})"
        )
    if refused or flagged:
        found.append(f"sensing refused {refused} frame sets and flagged {_count(flagged, 'estimate')}")
    if run.restarts:
        found.append(f"{' and '.join(sorted({who for _, who in run.restarts}))} began anew in the middle")
    missing = max(run.losses, sum(topic.missing for topic in run.traffic.values()))
    if missing:
        found.append(f"{_count(missing, 'publication')} missing from the recording")
    if unreadable := sum(topic.unreadable for topic in run.traffic.values()):
        found.append(f"{_count(unreadable, 'publication')} could not be read")
    if not finished:
        found.append("the recording was cut off before its end")
    if findings.warnings and not found:
        found.append(f"the log holds {_count(len(findings.warnings), 'warning')}")
    return found


def _first(findings: Findings, time_ns: int) -> str:
    return f"{findings.second(time_ns):.1f} s"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _sentence(pieces: Sequence[str]) -> str:
    text = "; ".join(pieces)
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
