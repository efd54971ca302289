"""The table of topics holds together."""

import itertools

import pytest
import zenoh

from messaging import topics
from messaging.topics import SERVICES, SIGNALS, TOPICS, Service, Signal, Topic

LINES = (*TOPICS, *SERVICES, *SIGNALS)


def test_keys_are_unique():
    keys = [line.key for line in LINES]
    assert len(set(keys)) == len(keys)


def test_the_table_holds_every_line_of_the_module():
    lines = [value for value in vars(topics).values() if isinstance(value, Topic | Service | Signal)]
    assert {line.key for line in lines} == {line.key for line in LINES}


@pytest.mark.parametrize("line", LINES, ids=lambda line: line.key)
def test_keys_are_key_expressions_below_the_bench(line):
    zenoh.KeyExpr(line.key)
    assert not line.key.startswith("nodal")


def test_no_publication_belongs_to_two_topics():
    for one, other in itertools.combinations([zenoh.KeyExpr(topic.key) for topic in (*TOPICS, *SIGNALS)], 2):
        assert not one.intersects(other)


@pytest.mark.parametrize("topic", [topic for topic in TOPICS if topic.logged], ids=lambda topic: topic.key)
def test_what_is_logged_has_a_schema(topic):
    assert topic.type.protobuf.DESCRIPTOR.full_name


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.key)
def test_ages_allow_at_least_two_messages_to_be_missed(topic):
    if topic.maximum_age_s is not None:
        assert topic.maximum_age_s * topic.rate_hz >= 3


@pytest.mark.parametrize("line", LINES, ids=lambda line: line.key)
def test_every_line_says_what_it_is(line):
    assert line.meaning


def test_a_camera_topic_is_named_after_its_camera():
    assert topics.CAMERA.named("left").key == "camera/left"
    assert topics.CAMERA_POSE.named("left").type is topics.CAMERA_POSE.type


def test_the_loop_cannot_hear_the_truth():
    assert topics.TRUTH.said_by == "simulated bench"
