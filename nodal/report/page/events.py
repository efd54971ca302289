"""What was asked, what happened and what was said: tables of events."""

from collections.abc import Callable, Iterable, Sequence

from nodal.report.bench_run import Line
from nodal.report.findings import Findings
from nodal.report.page.markup import Content, element, folded, table
from nodal.report.page.numbers import with_unit
from nodal.report.requests import request_in_words, target_in_words
from nodal.report.stretches import Stretch, without_numbers

MOST_ROWS = 300
"""A longer table ends by saying how much was left out."""


def requests(findings: Findings) -> list[Content]:
    """Every request with its answer, and the targets that were taken up."""
    run = findings.run
    if not run.asked and not run.accepted:
        return [element("p", "Nothing was asked while this was recorded.")]
    asked = (
        (
            _when(findings, asked.time_ns),
            asked.service,
            request_in_words(asked),
            "accepted" if asked.accepted else "refused",
            asked.state,
            asked.reason,
        )
        for asked in run.asked
    )
    taken = ((_when(findings, one.time_ns), target_in_words(one.target)) for one in run.accepted)
    return [
        _table("Requests", ["at", "service", "request", "answer", "state then", "reason"], list(asked)),
        _table("Targets taken up", ["at", "target"], list(taken)),
    ]


def interruptions(findings: Findings) -> list[Content]:
    """Faults, holds by kind, restarts, and every stretch."""
    faults = [(_when(findings, fault.begin_ns), _seconds(fault), fault.reason) for fault in findings.faults]
    restarts = [(_when(findings, time_ns), who) for time_ns, who in findings.run.restarts]
    every = [
        (_when(findings, one.begin_ns), _seconds(one), str(one.state), one.target_name, one.reason)
        for one in findings.stretches
    ]
    return [
        _table("Faults", ["at", "for", "reason"], faults),
        _table(
            "Holds that nobody asked for",
            ["kind", "count", "in all", "longest", "first at", "first in full"],
            [_hold(findings, kind, found) for kind, found in _by_kind(findings.waits)],
        ),
        _table("Restarts", ["at", "process"], restarts),
        folded(
            f"Every change of state ({len(every)})",
            _table("Changes of state", ["at", "for", "state", "target", "reason"], every),
        )
        if every
        else element("p", "No controller spoke while this was recorded."),
    ]


def doubts(findings: Findings) -> list[Content]:
    """What sensing flagged or refused, by kind, each with its first example."""
    run = findings.run
    flagged = [
        (
            flag,
            str(count),
            next(
                f"frame set {shape.sequence} after {_when(findings, shape.capture_time_ns)}"
                for shape in run.usable
                if flag in shape.flags
            ),
        )
        for flag, count in findings.flags.most_common()
    ]
    refused = [
        (
            kind,
            str(count),
            next(
                f"frame set {shape.sequence} after {_when(findings, shape.capture_time_ns)}: {shape.refusal}"
                for shape in run.shapes
                if without_numbers(shape.refusal) == kind
            ),
        )
        for kind, count in findings.refusals.most_common()
    ]
    methods = ", ".join(f"{name} ({count} frame sets)" for name, count in findings.methods.most_common())
    return [
        element("p", f"Method: {methods}.") if methods else None,
        _table("Flags", ["flag", "estimates", "first"], flagged),
        _table("Refusals", ["kind", "frame sets", "first"], refused),
    ]


def said(findings: Findings) -> list[Content]:
    """Log lines of warning and above; the others folded away."""
    if not findings.run.lines:
        return [element("p", "The recording holds no lines of the log.")]
    header = ["at", "level", "process", "text"]

    def rows(lines: Iterable[Line]) -> list[Sequence[Content]]:
        return [
            (_when(findings, one.time_ns), one.level_name.lower(), one.process, one.text) for one in lines
        ]

    return [
        _table("Warnings and errors", header, rows(findings.warnings))
        or element("p", "Nobody warned of anything."),
        folded(
            f"All lines ({len(findings.run.lines)})", _table("All lines", header, rows(findings.run.lines))
        ),
    ]


def _table(caption: str, header: Sequence[str], rows: Sequence[Sequence[Content]]) -> list[Content]:
    if not rows:
        return []
    left_out = len(rows) - MOST_ROWS
    return [
        element("h3", caption),
        table(caption, header, rows[:MOST_ROWS]),
        element("p", element("small", f"{left_out} more are in the recording.")) if left_out > 0 else None,
    ]


def _hold(findings: Findings, kind: str, found: Sequence[Stretch]) -> Sequence[Content]:
    return (
        kind,
        str(len(found)),
        with_unit(sum(one.duration_s for one in found), "s"),
        with_unit(max(one.duration_s for one in found), "s"),
        _when(findings, found[0].begin_ns),
        found[0].reason,
    )


def _by_kind(found: Iterable[Stretch]) -> list[tuple[str, list[Stretch]]]:
    """The most frequent kind first."""
    kinds: dict[str, list[Stretch]] = {}
    for stretch in found:
        kinds.setdefault(without_numbers(stretch.reason), []).append(stretch)
    size: Callable[[tuple[str, list[Stretch]]], int] = lambda item: -len(item[1])  # noqa: E731
    return sorted(kinds.items(), key=size)


def _when(findings: Findings, time_ns: int) -> str:
    return with_unit(findings.second(time_ns), "s")


def _seconds(stretch: Stretch) -> str:
    return with_unit(stretch.duration_s, "s")
