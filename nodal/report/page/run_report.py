"""One run, worked out: its figures, charts and verdict. Nothing here is drawn yet."""

import dataclasses
from collections.abc import Mapping
from functools import cached_property

from nodal.report.charts import Chart
from nodal.report.figures.control import control
from nodal.report.figures.model import Chapter, Figure, as_builtins
from nodal.report.figures.recording import recording
from nodal.report.figures.sensing import sensing
from nodal.report.findings import Findings
from nodal.report.page.numbers import utc
from nodal.report.requests import request_in_words
from nodal.report.run_charts import run_charts
from nodal.report.source import Source
from nodal.report.verdict import Verdict, verdict
from recordings import Log


@dataclasses.dataclass(frozen=True)
class RunReport:
    """One run, worked out and ready to be shown; `name` tells it from the others on the page."""

    name: str
    log: Log
    source: Source
    findings: Findings

    @cached_property
    def chapters(self) -> tuple[Chapter, ...]:
        """Every figure."""
        return (*sensing(self.findings), *control(self.findings), recording(self.findings.run))

    @cached_property
    def charts(self) -> Mapping[str, tuple[Chart, ...]]:
        """Every chart, by chapter."""
        return run_charts(self.findings)

    @cached_property
    def verdict(self) -> Verdict:
        """In two sentences."""
        return verdict(self.findings, self.source.damage, finished=bool(self.source.ending))

    def figure(self, chapter: str, group: str, key: str) -> Figure | None:
        """One figure; None when this run has none."""
        return next(
            (
                figure
                for known in self.chapters
                for one in known.groups
                for figure in one.figures
                if (known.key, one.title, figure.key) == (chapter, group, key) and figure.value is not None
            ),
            None,
        )

    def as_builtins(self) -> dict[str, object]:
        """Everything but pictures, in plain values."""
        findings, source = self.findings, self.source
        return {
            "recording": str(source.path),
            "bench": source.bench_name,
            "start": utc(findings.run.start_ns),
            "verdict": dataclasses.asdict(self.verdict),
            "damage": list(source.damage),
            "asked": [
                {
                    "at_s": round(findings.second(asked.time_ns), 3),
                    "service": asked.service,
                    "request": request_in_words(asked),
                    "accepted": asked.accepted,
                    "state": asked.state,
                    "reason": asked.reason,
                }
                for asked in findings.run.asked
            ],
            "faults": [
                {
                    "at_s": round(findings.second(fault.begin_ns), 3),
                    "for_s": round(fault.duration_s, 3),
                    "reason": fault.reason,
                }
                for fault in findings.faults
            ],
            "figures": as_builtins(self.chapters),
        }
