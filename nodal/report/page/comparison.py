"""Several runs side by side: figures with their differences, and the same charts over one another."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from nodal.report.charts import Chart, overlaid
from nodal.report.figures.model import Chapter
from nodal.report.page.markup import Content, element, folded, section, table
from nodal.report.page.numbers import utc, with_unit
from nodal.report.page.run_page import TITLES, drawn
from nodal.report.page.run_report import RunReport
from nodal.report.page.tables import side_by_side


def comparison(reports: Sequence[RunReport]) -> list[Element]:
    """Verdicts, charts and figures of all runs; differences are against the first."""
    return [
        section("runs", "Runs", _runs(reports)),
        section("charts", "Charts", drawn(_charts(reports), "all")),
        section("figures", "Figures", _figures(reports)),
    ]


def _runs(reports: Sequence[RunReport]) -> Element:
    return table(
        "Runs",
        ["run", "began", "length", "verdict", "what it did", "what is to be said against it"],
        (
            (
                element("a", report.name, href=f"#run{number}"),
                utc(report.findings.run.start_ns),
                with_unit((report.findings.run.end_ns - report.findings.run.start_ns) / 1e9, "s"),
                element("strong", TITLES[report.verdict.level], class_=f"level {report.verdict.level}"),
                report.verdict.done,
                report.verdict.wrong,
            )
            for number, report in enumerate(reports, start=1)
        ),
    )


def _charts(reports: Sequence[RunReport]) -> list[Chart]:
    """Every chart that at least two runs have and whose leading series can stand for the run."""
    found: dict[str, dict[str, Chart]] = {}
    for report in reports:
        for charts in report.charts.values():
            for chart in charts:
                if chart.rows is None and len(chart.series[0].x):
                    found.setdefault(chart.key, {})[report.name] = chart
    return [overlaid(charts) for charts in found.values() if len(charts) > 1]


def _figures(reports: Sequence[RunReport]) -> list[Content]:
    found: dict[str, dict[str, Chapter]] = {}
    for report in reports:
        for chapter in report.chapters:
            found.setdefault(chapter.key, {})[report.name] = chapter
    content: list[Content] = []
    for chapters in found.values():
        first = next(iter(chapters.values()))
        side = side_by_side(chapters)
        content.append(folded(first.title, side) if first.minor else [element("h3", first.title), side])
    return content
