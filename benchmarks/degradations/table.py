"""Outcomes counted into rows, and rows written as text, Markdown and JSON."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.degradations.running import Outcome
from benchmarks.poses import Array

NUMBER = re.compile(r"\d+(\.\d+)?")
COLUMNS = (
    "case",
    "level",
    "poses",
    "mean mm",
    "p95 mm",
    "max mm",
    "tip mm",
    "refused %",
    "flagged %",
    "silent %",
    "inside %",
    "cold ms",
    "warm ms",
    "flags",
)
LEGEND = (
    "Errors of nodal points 10 to 80 mm from the base, of estimates without a flag; tip: mean error at 80 mm. Shares are of\n"
    "estimates without a prior / with one; silent: no flag, and a nodal point is off by more than 1 mm; inside: nodal points\n"
    "whose truth lies in the 95 % ellipsoid. Times are medians. Flags and refusals (!) by how many estimates had them."
)


@dataclass(frozen=True, kw_only=True)
class Share:
    """Numbers of estimates of one kind."""

    estimates: int
    refused: int
    broken: int
    flagged: int
    silent: int
    median_ms: float

    @classmethod
    def of(cls, outcomes: Sequence[Outcome]) -> "Share":
        """Count them; every outcome is refused (broken ones are), flagged, or trusted."""
        return cls(
            estimates=len(outcomes),
            refused=sum(bool(outcome.refusal) for outcome in outcomes),
            broken=sum(outcome.broken for outcome in outcomes),
            flagged=sum(bool(outcome.flags) for outcome in outcomes),
            silent=sum(outcome.silent for outcome in outcomes),
            median_ms=1e3 * _of(np.median, [outcome.seconds for outcome in outcomes]),
        )


@dataclass(frozen=True, kw_only=True)
class Row:
    """One level's line. Errors and `inside` are of trusted estimates, and NaN where there are none."""

    method: str
    case: str
    level: str
    poses: int
    mean_mm: float
    p95_mm: float
    max_mm: float
    tip_mm: float
    inside: float
    cold: Share
    warm: Share
    reasons: dict[str, int]

    @classmethod
    def of(cls, method: str, case: str, level: str, poses: int, outcomes: Sequence[Outcome]) -> "Row":
        """Count the outcomes of one level."""
        trusted = [outcome for outcome in outcomes if outcome.trusted]
        errors = np.concatenate([np.empty(0), *(outcome.error_mm for outcome in trusted)])
        reasons = Counter(flag for outcome in outcomes for flag in outcome.flags)
        reasons.update("! " + NUMBER.sub("#", outcome.refusal) for outcome in outcomes if outcome.refusal)
        return cls(
            method=method,
            case=case,
            level=level,
            poses=poses,
            mean_mm=_of(np.mean, errors),
            p95_mm=_of(lambda values: np.percentile(values, 95), errors),
            max_mm=_of(np.max, errors),
            tip_mm=_of(np.mean, [outcome.error_mm[-1] for outcome in trusted]),
            inside=_of(np.mean, np.concatenate([np.empty(0), *(outcome.inside for outcome in trusted)])),
            cold=Share.of([outcome for outcome in outcomes if not outcome.warm]),
            warm=Share.of([outcome for outcome in outcomes if outcome.warm]),
            reasons=dict(reasons.most_common()),
        )


def cells(row: Row) -> tuple[str, ...]:
    """The texts of a row, one for each of COLUMNS."""
    both = row.cold, row.warm
    return (
        row.case,
        row.level,
        str(row.poses),
        *(_mm(value) for value in (row.mean_mm, row.p95_mm, row.max_mm, row.tip_mm)),
        *(
            _percent([(getattr(kind, name), kind.estimates) for kind in both])
            for name in ("refused", "flagged", "silent")
        ),
        "-" if np.isnan(row.inside) else f"{100 * row.inside:.0f}",
        *("-" if np.isnan(kind.median_ms) else f"{kind.median_ms:.0f}" for kind in both),
        _reasons(row.reasons),
    )


def as_line(texts: Sequence[str], case_width: int, level_width: int) -> str:
    """Texts of one line of the printed table, under those of other lines of the same widths."""
    widths = [case_width, level_width, *(max(len(name), 7) for name in COLUMNS[2:-1])]
    words = [text.ljust(width) for text, width in zip(texts[:2], widths, strict=False)]
    figures = [text.rjust(width) for text, width in zip(texts[2:-1], widths[2:], strict=True)]
    return "  ".join([*words, *figures, texts[-1]]).rstrip()


def as_markdown(rows: Iterable[Row]) -> str:
    """A Markdown table, and what its columns mean."""
    rule = ["---", "---", *["---:"] * (len(COLUMNS) - 3), "---"]
    lines = [COLUMNS, rule, *([text.replace("|", "\\|") for text in cells(row)] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + f"\n\n{LEGEND}\n"


def as_json(rows: Iterable[Row]) -> str:
    """A list of objects, one for each row; what there is no figure for is null."""
    return json.dumps([_without_nan(asdict(row)) for row in rows], indent=1) + "\n"


def _without_nan(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: _without_nan(value)
        if isinstance(value, dict)
        else None
        if isinstance(value, float) and np.isnan(value)
        else value
        for name, value in values.items()
    }


def _reasons(reasons: dict[str, int]) -> str:
    return ", ".join(f"{reason[:60]} {count}" for reason, count in list(reasons.items())[:3])


def _percent(counts: Iterable[tuple[int, int]]) -> str:
    return "/".join("-" if not of else f"{100 * count / of:.0f}" for count, of in counts)


def _mm(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.3f}"


def _of(figure: Callable[[Array], Any], values: Sequence[float] | Array) -> float:
    return float(figure(np.asarray(values))) if len(values) else float("nan")
