"""The page of one run, section by section."""

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from messaging.control import State
from nodal.report.bench_run import BenchRun
from nodal.report.charts import Chart
from nodal.report.page import events
from nodal.report.page.frames import moment_pictures
from nodal.report.page.markup import Content, element, figure, folded, section, vector
from nodal.report.page.numbers import megabytes, shown, utc, with_unit
from nodal.report.page.run_report import RunReport
from nodal.report.page.tables import figure_tables
from nodal.report.pictures.chart import as_svg
from nodal.report.source import Source
from nodal.report.verdict import Level, Verdict

HIGHLIGHTS = (
    ("truth", "all nodal points", "mean_mm", "mean error of nodal points"),
    ("truth", "all nodal points", "inside_percent", "of nodal points within their 95 % ellipsoid"),
    ("sensing", "estimates", "rate_hz", "rate of estimates"),
    ("latency", "capture to command", "p50_ms", "capture to command, median"),
    ("latency", "capture to command", "p99_ms", "capture to command, 99 % below"),
    ("loop", "lateness of a cycle", "p99_ms", "lateness of a cycle, 99 % below"),
    ("states", "interruptions", "holds", "holds that nobody asked for"),
    ("states", "interruptions", "faults", "faults"),
    ("recorder", "recording", "missing", "publications missing"),
)
"""Figures that say most, where there are any."""

TITLES = {
    Level.GOOD: "All well",
    Level.REMARKS: "With remarks",
    Level.BAD: "Something went wrong",
}

STATES = {str(state): f"var(--state-{state})" for state in State if state is not State.IDLE}
MARKS = {
    "centreline as estimated": "#45b8ff",
    "nodal points as estimated": "#ff5470",
    "where they should have been": "#ffd84d",
}
"""Colours behind curves and over pictures; style.css has the same."""


def run_sections(report: RunReport, anchor: str) -> list[Element]:
    """What follows the heading; `anchor` begins every name that links lead to."""
    findings, source = report.findings, report.source

    def chapter(key: str, *, titled: bool = False) -> Content:
        """A chapter's charts and figures, as far as this run has any."""
        known = next((known for known in report.chapters if known.key == key), None)
        return [
            element("h3", known.title) if known and titled else None,
            drawn(report.charts.get(key, ()), f"{anchor}-{key}"),
            figure_tables(known) if known else None,
        ]

    contents: tuple[tuple[str, str, Content], ...] = (
        ("asked", "What was asked", events.requests(findings)),
        (
            "happened",
            "What happened",
            [
                chapter("what-happened"),
                _key(STATES) if findings.stretches else None,
                events.interruptions(findings),
                chapter("states", titled=True),
            ],
        ),
        ("tracking", "Tracking", chapter("tracking")),
        ("pictures", "Pictures", _pictures(report)),
        (
            "sensing",
            "Sensing",
            [
                chapter("sensing"),
                events.doubts(findings),
                *(chapter(key, titled=True) for key in ("truth", "quality", "cameras", "stages")),
            ],
        ),
        ("latency", "Latencies", chapter("latency")),
        ("loop", "Control loop", chapter("loop")),
        ("tendons", "Tendons and stage", chapter("tendons")),
        ("recorder", "Recording", [_facts(source, findings.run), chapter("recorder")]),
        ("log", "Log", events.said(findings)),
        ("settings", "Settings that ran", _settings(source)),
    )
    return [section(f"{anchor}-{key}", title, *_or_nothing(content)) for key, title, content in contents]


def heading(report: RunReport) -> list[Content]:
    """Which run, when, the verdict, and the figures that say most."""
    run, source = report.findings.run, report.source
    length = with_unit((run.end_ns - run.start_ns) / 1e9, "s")
    when = f"{utc(run.start_ns)}, {length}" if run.traffic else "empty"
    bench = f"bench {source.bench_name}, " if source.bench_name else ""
    return [
        element("h1", report.name),
        element("p", f"{bench}{when}", class_="when"),
        stated(report.verdict),
        _tiles(report),
    ]


def stated(found: Verdict) -> Element:
    """A verdict with its level."""
    return element(
        "div",
        element("strong", TITLES[found.level]),
        element("p", found.done),
        element("p", found.wrong),
        class_=f"verdict {found.level}",
    )


def drawn(charts: Sequence[Chart], salt: str) -> Element | None:
    """Charts with their titles, two abreast where there is room."""
    if not charts:
        return None
    return element(
        "div",
        (
            figure(
                vector(as_svg(chart, f"{salt}-{chart.key}"), chart.in_words()), chart.title, wide=chart.wide
            )
            for chart in charts
        ),
        class_="charts",
    )


def _tiles(report: RunReport) -> Element:
    tiles = []
    known = {label: tracking.rms_mm() for label, tracking in report.findings.tracking.items()}
    tracked = {label: rms_mm for label, rms_mm in known.items() if rms_mm is not None}
    if tracked:
        longest = max(tracked, key=lambda label: len(report.findings.tracking[label].time_ns))
        kind = "in truth" if report.findings.true else "as measured"
        tiles.append((with_unit(tracked[longest], "mm"), f"RMS off {longest}, {kind}"))
    for chapter, group, key, label in HIGHLIGHTS:
        if found := report.figure(chapter, group, key):
            tiles.append((shown(found), label))
    return element(
        "ul",
        (element("li", element("b", value), element("span", label)) for value, label in tiles),
        class_="tiles",
    )


def _pictures(report: RunReport) -> list[Content]:
    pictures = moment_pictures(report.log, report.findings)
    if not pictures:
        return []
    return [_key(MARKS), element("div", pictures, class_="moments")]


def _key(colours: Mapping[str, str]) -> Element:
    """What colours mean."""
    return element(
        "p",
        (
            [element("span", words, class_="key", style=f"--key:{colour}"), " "]
            for words, colour in colours.items()
        ),
        class_="keys",
    )


def _facts(source: Source, run: BenchRun) -> list[Content]:
    """Files, versions, what is attached, and what is wrong with them."""
    facts: dict[str, list[str]] = {
        "files": [f"{path.name}, {megabytes(size)}" for path, size in source.files.items()],
        "ended": [source.ending or "cut off, or its next part is not here"],
        "versions": [f"{name} {version}" for name, version in source.versions.items()],
        "attached": list(source.attached),
        "calibration": [source.rig_problem] if source.rig_problem else [],
        "lost": [f"{count} of {topic}" for topic, count in source.lost.items()],
        "damage": list(source.damage),
        "unreadable": [
            f"{topic.unreadable} of {key}; the first: {topic.unreadable_example}"
            for key, topic in run.traffic.items()
            if topic.unreadable
        ],
    }
    return [
        element(
            "dl",
            (
                [element("dt", name), (element("dd", value) for value in values)]
                if name in ("files", "damage", "unreadable")
                else [element("dt", name), element("dd", ", ".join(values))]
                for name, values in facts.items()
                if values
            ),
            class_="facts",
        )
    ]


def _settings(source: Source) -> Content:
    return folded("The effective bench file", element("pre", source.bench_text)) if source.bench_text else []


def _or_nothing(content: Content) -> list[Content]:
    """The content, or words where there is none."""
    return [content if _holds(content) else element("p", "The recording holds nothing of this.")]


def _holds(content: Content) -> bool:
    if content is None or isinstance(content, str | Element):
        return content is not None
    return any(_holds(piece) for piece in content)
