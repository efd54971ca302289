"""The outcome of replays in words, and as one JSON object."""

from collections.abc import Iterator, Sequence

import msgspec

from nodal.replay.comparison import IGNORED, Tally
from nodal.replay.verification import Verdict


class Totals(msgspec.Struct, frozen=True, kw_only=True):
    """All logs together. `same` when every log could be replayed and nothing differs."""

    same: bool
    logs: int
    compared: int
    different: int
    ignored: dict[str, tuple[str, ...]]
    verdicts: list[Verdict]


def totals_of(verdicts: Sequence[Verdict]) -> Totals:
    """One summary of many verdicts."""
    return Totals(
        same=all(verdict.same for verdict in verdicts),
        logs=len(verdicts),
        compared=sum(verdict.comparison.compared for verdict in verdicts),
        different=sum(verdict.comparison.different for verdict in verdicts),
        ignored={kind.__name__: fields for kind, fields in IGNORED.items()},
        verdicts=list(verdicts),
    )


def as_text(verdict: Verdict) -> str:
    """A few lines: the outcome, then by topic what was compared, what differs, where first, and what could not be replayed."""
    return "\n".join(_lines(verdict))


def ignored_in_words() -> str:
    """Which fields no comparison looks at."""
    return "not compared, being durations: " + "; ".join(
        f"{kind.__name__} {', '.join(fields)}" for kind, fields in IGNORED.items()
    )


def _lines(verdict: Verdict) -> Iterator[str]:
    if verdict.error:
        yield f"{verdict.log}: not replayed"
        return
    comparison = verdict.comparison
    outcome = "same" if verdict.same else "DIFFERENT" if comparison.different else "nothing could be compared"
    if verdict.out:
        outcome = f"written to {verdict.out}; against the log: {outcome.lower()}"
    speed = f", {verdict.span_s / verdict.took_s:.1f} x real time" if verdict.took_s else ""
    yield f"{verdict.log}: {outcome} ({verdict.span_s:.1f} s in {verdict.took_s:.1f} s{speed})"
    for key, tally in comparison.topics.items():
        yield f"  {key:<20} {tally.compared:>8} compared, {tally.different} differ"
        yield from _differences(tally)
    for key, reasons in comparison.skipped.items():
        for reason, count in reasons.items():
            yield f"  {key:<20} {count:>8} not replayed: {reason}"
    for damage in verdict.damage:
        yield f"  damage: {damage}"


def _differences(tally: Tally) -> Iterator[str]:
    for name, difference in tally.fields.items():
        by = "" if difference.largest is None else f", by {difference.largest:.3g} at most"
        yield f"    {name}: in {difference.count}{by}; first at {difference.first_time_ns} ns"
        yield f"      logged   {difference.first_logged}"
        yield f"      replayed {difference.first_replayed}"
