"""What has come is taken in the order in which it was said, and nothing keeps the rest waiting."""

from collections import deque

import pytest

from messaging.errors import CodecError
from messaging.session import Received
from messaging.topics import CAMERA, SHAPE, TENDON_COMMAND, TOPICS
from recordings.hearing import SWEEP, Hearing


class Rings:
    """A session whose rings are filled by the test."""

    def __init__(self):
        self.waiting = {topic.key: deque() for topic in TOPICS}
        self.depths = {}

    def every(self, topic, depth):
        self.depths[topic.key] = depth
        ring = self.waiting[topic.key]

        class Ring:
            def take(self):
                one = ring.popleft() if ring else None
                if isinstance(one, CodecError):
                    raise one
                return one

        return Ring()

    def say(self, topic, publish_time_ns):
        self.waiting[topic.key].append(
            Received(key=topic.key, payload=b"", sequence=0, publish_time_ns=publish_time_ns, epoch=0)
        )


@pytest.fixture
def rings():
    return Rings()


def refuse(error):
    raise error


def test_everything_that_is_logged_is_heard_and_nothing_else(rings):
    Hearing(rings, 77)
    assert rings.depths == {topic.key: 77 for topic in TOPICS if topic.logged}


def test_topics_are_heard_in_the_order_of_their_publish_times_and_log_times_increase(rings):
    hearing = Hearing(rings, 77)
    for topic, publish_time_ns in [(TENDON_COMMAND, 3), (TENDON_COMMAND, 7), (SHAPE, 5), (CAMERA, 4)]:
        rings.say(topic, publish_time_ns)
    heard = hearing.take(1000, refuse)
    assert [(one.topic.key, one.received.publish_time_ns) for one in heard] == [
        ("tendon/command", 3),
        ("camera/*", 4),
        ("shape", 5),
        ("tendon/command", 7),
    ]
    rings.say(SHAPE, 8)
    times = [one.log_time_ns for one in heard + hearing.take(1000, refuse)]
    assert times[0] == 1000
    assert times == sorted(set(times))
    assert hearing.take(2000, refuse) == []


def test_a_busy_topic_keeps_no_other_waiting(rings):
    hearing = Hearing(rings, 77)
    for number in range(3 * SWEEP):
        rings.say(TENDON_COMMAND, number)
    rings.say(SHAPE, 10**6)
    heard = hearing.take(0, refuse)
    assert len(heard) == SWEEP + 1
    assert heard[-1].topic is SHAPE


def test_what_has_no_envelope_is_refused_and_the_rest_is_heard(rings):
    hearing = Hearing(rings, 77)
    rings.say(SHAPE, 1)
    rings.waiting[SHAPE.key].append(CodecError("no envelope"))
    rings.say(SHAPE, 2)
    refused = []
    assert [one.received.publish_time_ns for one in hearing.take(0, refused.append)] == [1, 2]
    assert [str(error) for error in refused] == ["no envelope"]
