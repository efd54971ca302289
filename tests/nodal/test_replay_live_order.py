"""Live replay without a bus: what is said in which order, how lateness is told, and which topics a word means."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from messaging import topics
from nodal.errors import CommandError
from nodal.replay.live.order import by_publication, read_ahead, timeline
from nodal.replay.live.pace import Lateness
from nodal.replay.live.topics import DEFAULT, chosen
from recordings.reader import Recorded

START_NS = 1_700_000_000_000_000_000
MS = 1_000_000


def one(number, publish_ms, wait_ms, topic="truth"):
    """A recorded message that was said at this time and logged that much later."""
    return Recorded(
        path=Path("a.mcap"),
        topic=topic,
        schema="nodal.Truth",
        log_time_ns=START_NS + (publish_ms + wait_ms) * MS,
        publish_time_ns=START_NS + publish_ms * MS,
        sequence=number,
        payload=b"",
    )


@given(
    st.lists(st.tuples(st.integers(0, 5000), st.integers(-2000, 3000), st.sampled_from("ab")), max_size=60)
)
def test_everything_is_said_once_in_order_of_saying_each_topic_in_its_own(moments):
    recorded = sorted(
        (one(number, publish, wait, topic) for number, (publish, wait, topic) in enumerate(moments)),
        key=lambda message: message.log_time_ns,
    )
    said = list(by_publication(recorded))
    assert [time_ns for time_ns, _ in said] == sorted(time_ns for time_ns, _ in said)
    for topic in "ab":
        assert [m for _, m in said if m.topic == topic] == [m for m in recorded if m.topic == topic]


def test_the_publish_time_counts_unless_the_recorder_cannot_have_heard_it_then():
    recorded = [one(0, 0, 900), one(1, 10, 900, "shape"), one(2, 20, 5000, "a"), one(3, 9000, -30, "b")]
    recorded.sort(key=lambda message: message.log_time_ns)
    at_ms = {message.sequence: (time_ns - START_NS) / MS for time_ns, message in by_publication(recorded)}
    assert at_ms == {0: 0, 1: 10, 2: 5020, 3: 8970}


def test_rounds_follow_one_another_until_one_is_empty():
    rounds = [[one(0, 100, 1), one(1, 140, 1)], [one(2, 100, 1)], [], [one(3, 0, 0)]]
    due = [(due_ns / MS, message.sequence) for due_ns, message in timeline(rounds)]
    assert due == [(0, 0), (40, 1), (90, 2)]


def test_reading_ahead_changes_nothing_and_hands_errors_on():
    def broken():
        yield from items
        raise CommandError("the disk is gone")

    items = [(number, one(number, number, 0)) for number in range(700)]
    with ThreadPoolExecutor(1) as executor:
        assert list(read_ahead(iter(items), executor)) == items
        got = []
        with pytest.raises(CommandError, match="the disk is gone"):
            got.extend(read_ahead(broken(), executor))


def test_lateness_is_told_by_quantiles():
    lateness = Lateness()
    assert lateness.quantile_ms(0.5) == 0
    for late_ms in range(1, 101):
        lateness.add(late_ms / 1e3)
    assert [lateness.quantile_ms(share) for share in (0.5, 0.99, 1.0)] == pytest.approx([50, 99, 100])


def test_without_a_word_everything_is_said_that_feeds_a_controller_and_nothing_of_its_own():
    said_by = {topic.said_by for topic in chosen(DEFAULT)}
    assert said_by == {"sensing", "simulated bench"}
    assert topics.SHAPE in chosen(DEFAULT)
    assert all(topic.logged for topic in chosen(("all",)))
    assert {topic.key for topic in chosen(("camera/left", "tendon/state"))} == {"camera/left", "tendon/state"}
    assert topics.CAMERA in chosen(("camera/*",))


@pytest.mark.parametrize("word", ["shapes", "", "recorder", "simulated/camera/left"])
def test_an_unknown_word_is_refused(word):
    with pytest.raises(CommandError, match="neither a key that is recorded"):
        chosen((word,))
