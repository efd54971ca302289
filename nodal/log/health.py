"""What is to be said against a recording: one finding a line. Pure."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from messaging.control import State
from messaging.errors import NodalError
from messaging.topics import (
    CAMERA,
    CONTROLLER_MEMORY,
    CONTROLLER_STATE,
    SENSING_MEMORY,
    SHAPE,
    TENDON_COMMAND,
)
from nodal.bench_file import recorded_bench
from nodal.log.lines import counted, hertz, seconds, utc
from nodal.log.survey import Survey
from nodal.log.traffic import Silence, without_partner
from nodal.report.traffic import ONE_VOICE
from recordings.reader import names, topic_of

LEAST_RATE = 0.9
"""Of what is expected; below it a topic is too slow."""
LARGEST_SHARE = 0.05
"""Of all shapes that may be flagged, refused or old before it is worth a finding."""
PERIODS_MISSED = 3.5
"""A topic may be silent for as many periods of its bench, also where the table of topics would have it sooner."""
MOVING = {State.HOMING, State.TRACKING}
"""States in which commands follow one another without a pause."""


@dataclass(frozen=True)
class Finding:
    """What is wrong: the kind of it, and in words what, by how much, and what is expected."""

    kind: str
    text: str


def findings(survey: Survey) -> list[Finding]:
    """Everything; nothing for a healthy recording. The most serious stand first."""
    sources = (
        _files,
        _damage,
        _faults,
        _restarts,
        _times,
        _losses,
        _replay,
        _rates,
        _silences,
        _partners,
        _shapes,
        _unreadable,
    )
    return [finding for source in sources for finding in source(survey)]


def _files(survey: Survey) -> Iterator[Finding]:
    for part in survey.parts:
        if part.in_use:
            yield Finding(
                "file", f"{part.path.name}: a recorder is writing it; it is finished once that ends"
            )
    if not survey.heard:
        yield Finding("file", f"{survey.log.path.name}: it holds no messages")


def _damage(survey: Survey) -> Iterator[Finding]:
    live = {part.path for part in survey.parts if part.in_use}
    for damage in survey.log.damage:
        if damage.path not in live:
            yield Finding("damage", str(damage))


def _times(survey: Survey) -> Iterator[Finding]:
    spans = [(part.path.name, part.span_ns) for part in survey.parts if part.span_ns]
    for (before, (_, end_ns)), (after, (begin_ns, _)) in pairwise(spans):
        if begin_ns < end_ns:
            yield Finding(
                "time",
                f"{after} begins {seconds((end_ns - begin_ns) / 1e9)} before {before} ends; log times never turn back",
            )
    for key, traffic in survey.traffic.items():
        for step in traffic.set_back[:1]:
            yield Finding(
                "time",
                f"{key}: publish times turn back by {seconds(-step.lasted_s)} at {_at(survey, step)}"
                + (f", and {len(traffic.set_back) - 1} times more" if len(traffic.set_back) > 1 else ""),
            )


def _losses(survey: Survey) -> Iterator[Finding]:
    for key in sorted(survey.lost.keys() | survey.traffic.keys()):
        counted_lost = survey.lost.get(key, 0)
        missing = survey.missing(key) or 0 if key in survey.traffic else 0
        # what a damaged place took is told of there
        missing = max(0, missing - sum(damage.missing[key] for damage in survey.log.damage))
        if counted_lost or missing:
            yield Finding(
                "losses",
                f"{key}: {counted(missing, 'number')} left out, {counted_lost} counted as lost by the recorder; expected 0",
            )


def _faults(survey: Survey) -> Iterator[Finding]:
    for spell in survey.spells:
        if spell.state == State.FAULT:
            yield Finding(
                "fault", f"at {survey.second(spell.begin_ns):.3f} s ({utc(spell.begin_ns)}): {spell.reason}"
            )


def _restarts(survey: Survey) -> Iterator[Finding]:
    for topic in ONE_VOICE:
        for restart in survey.traffic[topic.key].restarts if topic.key in survey.traffic else ():
            yield Finding(
                "restart",
                f"{topic.said_by} began anew; silent for {seconds(restart.lasted_s)} at {_at(survey, restart)}",
            )


def _replay(survey: Survey) -> Iterator[Finding]:
    """What it lacks for being replayed."""
    try:
        recorded_bench(survey.log.path, survey.log.attachments, {})
    except NodalError as error:
        yield Finding("replay", f"no replay without a bench: {error}")
    for said, memory in ((SHAPE, SENSING_MEMORY), (CONTROLLER_STATE, CONTROLLER_MEMORY)):
        if said.key in survey.heard and memory.key not in survey.heard:
            yield Finding(
                "replay", f"{memory.key}: none; without it {said.key} can be replayed from a start only"
            )


def _rates(survey: Survey) -> Iterator[Finding]:
    for key, traffic in survey.traffic.items():
        rate_hz, expected_hz = traffic.rate_hz, traffic.expected_hz
        if expected_hz and expected_hz > 1 and rate_hz is not None and rate_hz < LEAST_RATE * expected_hz:
            yield Finding("rate", f"{key}: {hertz(rate_hz)}; expected {hertz(expected_hz)}")


def _silences(survey: Survey) -> Iterator[Finding]:
    for key, traffic in survey.traffic.items():
        topic = topic_of(key)
        if topic is None or topic.maximum_age_s is None:
            continue
        limit_s = max(topic.maximum_age_s, PERIODS_MISSED / (traffic.expected_hz or math.inf))
        silences = traffic.silences(limit_s)
        if topic == TENDON_COMMAND:
            silences = [silence for silence in silences if _moving(survey, silence)]
        if silences:
            longest = max(silences, key=lambda silence: silence.lasted_s)
            yield Finding(
                "stale",
                f"{key}: silent {counted(len(silences), 'time')} for more than {limit_s:.3g} s, "
                f"longest {seconds(longest.lasted_s)} at {_at(survey, longest)}; expected never",
            )


def _partners(survey: Survey) -> Iterator[Finding]:
    cameras = {key: traffic for key, traffic in survey.traffic.items() if names(CAMERA, key)}
    alone = without_partner(list(cameras.values()))
    if alone:
        total = sum(traffic.count for traffic in cameras.values())
        yield Finding(
            "frames", f"{alone} of {total} frames of {', '.join(cameras)} have no partner; expected 0"
        )


def _shapes(survey: Survey) -> Iterator[Finding]:
    count = len(survey.capture_to_publish_ns)
    limit_s = SHAPE.maximum_age_s or 0.0
    old = sum(age > limit_s * 1e9 for age in survey.capture_to_publish_ns)
    flags = ", ".join(f"{flag} {number}" for flag, number in survey.flagged.most_common())
    for number, what in (
        (survey.suspicious, f"flagged ({flags})"),
        (survey.refused, "refused"),
        (old, f"older than {limit_s:.3g} s when published"),
    ):
        if number > LARGEST_SHARE * count:
            yield Finding(
                "shapes",
                f"{number} of {count} ({100 * number / count:.0f} %) {what}; at most {100 * LARGEST_SHARE:.0f} % is expected",
            )


def _unreadable(survey: Survey) -> Iterator[Finding]:
    for key, count in sorted(survey.unreadable.items()):
        yield Finding("messages", f"{key}: {counted(count, 'message')} cannot be decoded; expected 0")


def _moving(survey: Survey, silence: Silence) -> bool:
    return any(
        spell.state in MOVING and spell.begin_ns <= silence.begin_ns and silence.end_ns <= spell.end_ns
        for spell in survey.spells
    )


def _at(survey: Survey, silence: Silence) -> str:
    return f"{survey.second(silence.begin_ns):.3f} s ({utc(silence.begin_ns)})"
