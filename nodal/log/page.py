"""What `nodal log info` prints: a page of aligned sections, or the same as plain values. Pure."""

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

import numpy as np

from nodal.log.lines import aligned, counted, hertz, seconds, size, utc
from nodal.log.survey import Survey
from nodal.report.requests import request_in_words

INDENT = "  "
SHARES = (50, 95, 100)
MOST_SPELLS = 40
LINE = 110


def as_text(survey: Survey) -> str:
    """The page."""
    sections = {
        "files": list(_files(survey)),
        "attached": list(_attached(survey)),
        "versions": _versions(survey),
        "settings": list(_settings(survey)),
        "topics": list(_topics(survey)),
        "ages": list(_ages(survey)),
        "shapes": list(_shapes(survey)),
        "controller": list(_spells(survey)),
        "asked": list(_asked(survey)),
        "targets": [f"{_at(survey, time_ns)}  {name}" for time_ns, name in survey.targets],
        "damage": [str(damage) for damage in survey.log.damage],
    }
    lasted_s = (survey.end_ns - survey.begin_ns) / 1e9
    total = sum(traffic.count for traffic in survey.traffic.values())
    head = [str(survey.log.path)]
    if total:
        head.append(f"{utc(survey.begin_ns)}, {seconds(lasted_s)}, {counted(total, 'message')}")
    bodies = [
        "\n".join([name, *(INDENT + line for line in lines)]) for name, lines in sections.items() if lines
    ]
    return "\n\n".join(["\n".join(head), *bodies])


def as_builtins(survey: Survey) -> dict[str, Any]:
    """Everything on the page in plain values; times in Unix ns."""
    return {
        "recording": str(survey.log.path),
        "begin_ns": survey.begin_ns,
        "end_ns": survey.end_ns,
        "files": [
            {
                "path": str(part.path),
                "bytes": part.size_bytes,
                "begin_ns": part.span_ns[0] if part.span_ns else None,
                "end_ns": part.span_ns[1] if part.span_ns else None,
                "ended": part.ended or None,
                "being_written": part.in_use,
            }
            for part in survey.parts
        ],
        "attached": {name: len(data) for name, data in survey.log.attachments.items()},
        "versions": survey.versions,
        "settings": survey.bench,
        "topics": {
            key: {
                "type": traffic.heard.schema,
                "count": traffic.count,
                "bytes": traffic.heard.size_bytes,
                "rate_hz": traffic.rate_hz,
                "expected_hz": traffic.expected_hz,
                "largest_gap_s": traffic.largest_gap_s,
                "missing": survey.missing(key),
                "lost": survey.lost.get(key, 0),
            }
            for key, traffic in survey.traffic.items()
        },
        "capture_to_publish_ms": _percentiles(survey.capture_to_publish_ns),
        "capture_to_command_ms": _percentiles(survey.capture_to_command_ns),
        "shapes": {
            "count": len(survey.capture_to_publish_ns),
            "flagged": survey.suspicious,
            "refused": survey.refused,
            "flags": dict(survey.flagged),
        },
        "controller": [
            {
                "begin_ns": spell.begin_ns,
                "end_ns": spell.end_ns,
                "state": spell.state,
                "target": spell.target,
                "reason": spell.reason,
            }
            for spell in survey.spells
        ],
        "asked": [
            {
                "time_ns": asked.time_ns,
                "service": asked.service,
                "request": request_in_words(asked),
                "accepted": asked.accepted,
                "state": asked.state,
                "reason": asked.reason,
            }
            for asked in survey.asked
        ],
        "targets": [{"time_ns": time_ns, "name": name} for time_ns, name in survey.targets],
        "damage": [str(damage) for damage in survey.log.damage],
    }


def _files(survey: Survey) -> Iterator[str]:
    rows = []
    for part in survey.parts:
        begin_ns, end_ns = part.span_ns or (survey.begin_ns, survey.begin_ns)
        span = (
            f"{survey.second(begin_ns):.1f} to {survey.second(end_ns):.1f} s"
            if part.span_ns
            else "no messages"
        )
        ended = "is being written" if part.in_use else part.ended or "was cut off"
        rows.append((part.path.name, size(part.size_bytes), span, ended))
    yield from aligned(rows, right=(1,))


def _attached(survey: Survey) -> Iterator[str]:
    yield from aligned((name, size(len(data))) for name, data in survey.log.attachments.items())


def _versions(survey: Survey) -> list[str]:
    return wrap(", ".join(f"{name} {version}" for name, version in survey.versions.items()), LINE)


def _settings(survey: Survey) -> Iterator[str]:
    bench = survey.bench
    rows = []
    if name := bench.get("name"):
        rows.append(("bench", f"{name}{', on a simulated robot' if 'simulation' in bench else ''}"))
    if cameras := bench.get("cameras"):
        rows.append(("cameras", ", ".join(cameras)))
    robot, sensing, controller = (bench.get(room, {}) for room in ("robot", "sensing", "controller"))
    if lengths := robot.get("section_length_mm"):
        rows.append(
            ("robot", f"{len(lengths)} sections of {', '.join(f'{length:g}' for length in lengths)} mm")
        )
    if points := sensing.get("nodal_points"):
        rows.append(
            ("nodal points", ", ".join(f"{point['name']} at {point['arc_mm']:g} mm" for point in points))
        )
    if "law" in controller:
        rows.append(("controller", f"law {controller['law']} at {controller.get('rate_hz', 0):g} Hz"))
    yield from aligned(rows)


def _topics(survey: Survey) -> Iterator[str]:
    rows = [("topic", "type", "count", "size", "rate", "expected", "largest gap", "missing", "lost")]
    for key, traffic in survey.traffic.items():
        missing = survey.missing(key)
        rows.append(
            (
                key,
                traffic.heard.schema or "-",
                str(traffic.count),
                size(traffic.heard.size_bytes),
                hertz(traffic.rate_hz if traffic.expected_hz else None),
                hertz(traffic.expected_hz),
                seconds(traffic.largest_gap_s),
                "-" if missing is None else str(missing),
                str(survey.lost.get(key, 0)),
            )
        )
    yield from aligned(rows, right=(2, 3, 4, 5, 6, 7, 8))
    for key, what in survey.foreign.items():
        yield f"{key} is passed over: it holds {what}"
    for key, count in survey.unreadable.items():
        yield f"{key}: {counted(count, 'message')} cannot be decoded"


def _ages(survey: Survey) -> Iterator[str]:
    rows: list[tuple[str, ...]] = [("", "median", "95 %", "largest")]
    for name, ages_ns in (
        ("shape, capture to publish", survey.capture_to_publish_ns),
        ("tendon command, capture to command", survey.capture_to_command_ns),
    ):
        if ages := _percentiles(ages_ns):
            rows.append((name, *(f"{age:.1f} ms" for age in ages.values())))
    if len(rows) > 1:
        yield from aligned(rows, right=(1, 2, 3))


def _shapes(survey: Survey) -> Iterator[str]:
    count = len(survey.capture_to_publish_ns)
    if count:
        flags = ", ".join(f"{flag} {number}" for flag, number in survey.flagged.most_common())
        yield f"{count}, {survey.suspicious} flagged{f' ({flags})' if flags else ''}, {survey.refused} refused"


def _spells(survey: Survey) -> Iterator[str]:
    shown = survey.spells[:MOST_SPELLS]
    yield from aligned(
        (
            (
                _at(survey, spell.begin_ns),
                seconds((spell.end_ns - spell.begin_ns) / 1e9),
                spell.state,
                spell.target,
                spell.reason,
            )
            for spell in shown
        ),
        right=(0, 1),
    )
    if len(survey.spells) > len(shown):
        yield f"and {len(survey.spells) - len(shown)} more; --json names them all"


def _asked(survey: Survey) -> Iterator[str]:
    rows = [
        (
            _at(survey, asked.time_ns),
            asked.service,
            request_in_words(asked),
            "accepted" if asked.accepted else "refused",
            asked.reason,
        )
        for asked in survey.asked
    ]
    yield from aligned(rows, right=(0,))


def _at(survey: Survey, time_ns: int) -> str:
    return f"{survey.second(time_ns):.1f} s"


def _percentiles(ages_ns: list[int]) -> dict[str, float]:
    if not ages_ns:
        return {}
    values = np.percentile(np.array(ages_ns) / 1e6, SHARES)
    return dict(zip(("median", "95 %", "largest"), values.tolist(), strict=True))
