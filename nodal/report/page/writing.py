"""From recordings to one HTML file."""

import sys
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from xml.etree.ElementTree import Element

from nodal.errors import CommandError, ReportError
from nodal.report.findings import Findings
from nodal.report.loading import load_run
from nodal.report.page.comparison import comparison
from nodal.report.page.markup import Content, document, element
from nodal.report.page.numbers import megabytes
from nodal.report.page.run_page import heading, run_sections
from nodal.report.page.run_report import RunReport
from nodal.report.source import source_of
from recordings import Log

MADE_BY = "Made by nodal report. Everything is in this file."
STYLE = files("nodal.report.page").joinpath("style.css")


def write_page(recordings: Sequence[Path], page: Path | None) -> tuple[Path, list[RunReport]]:
    """One page for all of them, beside the first unless `page` names another place; returns it and what it shows.

    Raises CommandError, RecordingError, CalibrationFileError, ReportError, or NodalError without matplotlib.
    """
    logs = [Log(recording) for recording in recordings]
    page = page or _beside(recordings)
    _check_place(page, logs)
    reports = [_report(log, name) for log, name in zip(logs, _names(recordings), strict=True)]
    _say("drawing")
    text = _single(reports[0]) if len(reports) == 1 else _several(reports)
    data = text.encode(errors="replace")
    try:
        page.write_bytes(data)
    except OSError as error:
        raise ReportError(f"{page}: the page cannot be written: {error.strerror}") from error
    _say(f"{page}: {megabytes(len(data))}")
    return page, reports


def _report(log: Log, name: str) -> RunReport:
    _say(f"reading {log.path}, {megabytes(sum(part.stat().st_size for part in log.parts))}")
    findings = Findings(load_run(log))
    return RunReport(name, log, source_of(log), findings)


def _single(report: RunReport) -> str:
    sections = run_sections(report, "run1")
    return page_text(report.name, heading(report), sections, MADE_BY)


def _several(reports: Sequence[RunReport]) -> str:
    title = f"{len(reports)} runs side by side"
    compared = comparison(reports)
    parts = list(compared)
    for number, report in enumerate(reports, start=1):
        parts.append(
            element(
                "article",
                heading(report),
                run_sections(report, f"run{number}"),
                class_="run",
                id=f"run{number}",
            )
        )
    return page_text(title, element("h1", title), parts, MADE_BY)


def page_text(title: str, heading: Content, parts: Sequence[Element], footer: str) -> str:
    """A whole page: its heading, links to its parts, the parts."""
    style = STYLE.read_text(encoding="utf-8")
    return document(
        title, style, element("header", heading), _links(parts), *parts, element("footer", footer)
    )


def _links(parts: Sequence[Element]) -> Element:
    """To every part by its heading."""
    places = [(part.get("id"), part.findtext("h2") or part.findtext("h1", "")) for part in parts]
    return element(
        "nav", (element("a", name, href=f"#{anchor}") for anchor, name in places), aria_label="Sections"
    )


def _beside(recordings: Sequence[Path]) -> Path:
    first = recordings[0]
    more = f"-and-{len(recordings) - 1}-more" if len(recordings) > 1 else ""
    return first.with_name(f"{first.stem}{more}.html")


def _check_place(page: Path, logs: Sequence[Log]) -> None:
    taken = {part.resolve() for log in logs for part in log.parts}
    if page.resolve() in taken:
        raise CommandError(f"-o {page}: that is a recording; recordings are never overwritten")


def _names(recordings: Sequence[Path]) -> list[str]:
    """The shortest ends of their paths that tell them apart; numbered where nothing else does."""
    pieces = [recording.resolve().with_suffix("").parts for recording in recordings]
    longest = max(len(one) for one in pieces)
    for length in range(1, longest + 1):
        names = ["/".join(one[-length:]) for one in pieces]
        if len(set(names)) == len(names):
            return names
    return [f"{one[-1]} ({number})" for number, one in enumerate(pieces, start=1)]


def _say(text: str) -> None:
    print(f"nodal: {text}", file=sys.stderr, flush=True)
