"""What happened in a run, as its user names it: fault, hold, flag:tip_unseen, state:tracking, target:circle ..."""

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

from nodal.errors import CommandError

if TYPE_CHECKING:
    from nodal.report.findings import Findings
    from recordings import Log

KINDS = ("fault", "hold", "state", "target", "asked", "flag", "refusal", "restart", "warning")
"""`hold` is one that no operator asked for; flags and refusals happen where they begin, and so do faults and states."""
ALLOWED = (
    f"{', '.join(KINDS)}; or one of them by name: state:NAME, target:NAME, asked:SERVICE, flag:NAME, "
    "restart:PROCESS, warning:PROCESS"
)


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Events of one kind: of any name, or of this one. `text` is how they were asked for."""

    text: str
    kind: str
    name: str


@dataclass(frozen=True, kw_only=True)
class Event:
    """When something happened (Unix ns); `name` tells those of one kind apart, where they have one."""

    time_ns: int
    kind: str
    name: str = ""

    def __str__(self) -> str:
        """As it is asked for."""
        return f"{self.kind}:{self.name}" if self.name else self.kind


def event(text: str) -> Wanted:
    """What `fault` or `state:tracking` asks for; raises ArgumentTypeError."""
    kind, _, name = text.partition(":")
    if kind not in KINDS:
        raise argparse.ArgumentTypeError(f"{text!r} is no event; allowed are {ALLOWED}")
    return Wanted(text=text, kind=kind, name=name)


def times_of(log: "Log", wanted: Wanted) -> list[int]:
    """When it happened in this recording, Unix ns; raises CommandError when it did not, naming what did."""
    from nodal.report.findings import Findings  # noqa: PLC0415
    from nodal.report.loading import load_run  # noqa: PLC0415

    found = events(Findings(load_run(log)))
    times_ns = [one.time_ns for one in found if one.kind == wanted.kind and wanted.name in ("", one.name)]
    if not times_ns:
        raise CommandError(f"{log.path}: {wanted.text} does not occur; {_occurring(found)}")
    return times_ns


def events(findings: "Findings") -> list[Event]:
    """Everything that happened, in order of time."""
    run = findings.run
    found = [
        *_states(findings),
        *_doubts(findings),
        *(Event(time_ns=hold.begin_ns, kind="hold") for hold in findings.waits),
        *(Event(time_ns=one.time_ns, kind="target", name=one.target.name) for one in run.accepted),
        *(Event(time_ns=asked.time_ns, kind="asked", name=asked.service) for asked in run.asked),
        *(Event(time_ns=time_ns, kind="restart", name=who) for time_ns, who in run.restarts),
        *(Event(time_ns=line.time_ns, kind="warning", name=line.process) for line in findings.warnings),
    ]
    return sorted(found, key=lambda one: one.time_ns)


def _occurring(found: Sequence[Event]) -> str:
    counts = Counter(map(str, found))
    told = ", ".join(name if count == 1 else f"{name} ({count} times)" for name, count in counts.items())
    return f"what does: {told}" if told else "no event does"


def _states(findings: "Findings") -> Iterator[Event]:
    """Each change of the controller's state. A fault has a name of its own as well."""
    for state, stretches in groupby(findings.stretches, key=lambda stretch: stretch.state):
        first = next(stretches)
        yield Event(time_ns=first.begin_ns, kind="state", name=str(state))
        if first in findings.faults:
            yield Event(time_ns=first.begin_ns, kind="fault")


def _doubts(findings: "Findings") -> Iterator[Event]:
    """Where each flag, and refusals, begin."""
    shapes = findings.run.shapes
    captured_ns = [shape.capture_time_ns for shape in shapes]
    for flag in findings.flags:
        for time_ns in _begun(captured_ns, [flag in shape.flags for shape in shapes]):
            yield Event(time_ns=time_ns, kind="flag", name=flag)
    for time_ns in _begun(captured_ns, [bool(shape.refusal) for shape in shapes]):
        yield Event(time_ns=time_ns, kind="refusal")


def _begun(times_ns: Sequence[int], true: Sequence[bool]) -> Iterator[int]:
    """The times of those that are true and follow one that is not."""
    for time_ns, (before, now) in zip(times_ns, pairwise([False, *true]), strict=True):
        if now and not before:
            yield time_ns
