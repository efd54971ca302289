"""Figures of the recording itself: what was said how often, and what is missing."""

from nodal.report.bench_run import BenchRun
from nodal.report.figures.model import Chapter, Group, figures


def recording(run: BenchRun) -> Chapter:
    """All topics together, and each of them."""
    traffic = run.traffic
    whole = Group(
        "recording",
        figures(
            length_s=("length", (run.end_ns - run.start_ns) / 1e9),
            messages=("publications", sum(topic.messages for topic in traffic.values())),
            size_mb=("size of what was said", sum(topic.size_bytes for topic in traffic.values()) / 1e6),
            lost=("lost, as the recorder counted", run.losses),
            missing=("numbers left out", sum(topic.missing for topic in traffic.values())),
            unreadable=("unreadable", sum(topic.unreadable for topic in traffic.values())),
        ),
    )
    topics = (
        Group(
            key,
            figures(
                messages=("publications", topic.messages),
                rate_hz=("rate", topic.rate_hz),
                size_mb=("size", topic.size_bytes / 1e6),
                gap_s=("longest silence", topic.largest_gap_ns / 1e9),
                missing=("left out", topic.missing),
                restarts=("restarts", len(topic.restarts_ns)),
                unreadable=("unreadable", topic.unreadable),
            ),
        )
        for key, topic in sorted(traffic.items())
    )
    return Chapter("recorder", "Recorder", (whole, *topics), minor=True)
