"""What is not recorded yet is kept in order, within bounds, and what still holds is not forgotten."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from messaging.session import Received
from messaging.topics import (
    ASKED,
    CAMERA,
    CAMERA_POSE,
    LOG,
    SENSING_MEMORY,
    SHAPE,
    TARGET,
    TARGET_PATH,
    TOPICS,
)
from recordings.backlog import OVERHEAD_BYTES, SELDOM, Backlog, Heard


def heard(log_time_ns, topic=SHAPE, size=0, key=None):
    received = Received(
        key=key or topic.key,
        payload=bytes(size),
        sequence=log_time_ns,
        publish_time_ns=log_time_ns - 1,
        epoch=1,
    )
    return Heard(topic, received, log_time_ns)


def test_what_is_said_seldom_is_what_still_holds():
    assert {TARGET.key, TARGET_PATH.key, CAMERA_POSE.key, SENSING_MEMORY.key} <= SELDOM
    assert not {CAMERA.key, SHAPE.key, LOG.key, ASKED.key} & SELDOM
    assert {topic.key for topic in TOPICS} >= SELDOM


@given(st.lists(st.integers(0, 2000), max_size=40), st.integers(2**10, 2**14))
def test_the_newest_that_fit_are_kept(sizes, limit):
    backlog = Backlog(limit)
    for time_ns, size in enumerate(sizes):
        backlog.append(heard(time_ns, size=size))
        assert backlog.size_bytes <= limit
    kept = []
    while backlog.first_ns is not None:
        kept.append(backlog.pop().log_time_ns)
    assert kept == list(range(len(sizes)))[len(sizes) - len(kept) :]
    assert backlog.dropped == len(sizes) - len(kept)
    assert backlog.size_bytes == 0
    following = sizes[len(sizes) - len(kept) - 1 :]
    assert len(kept) == len(sizes) or sum(size + OVERHEAD_BYTES for size in following) > limit


def test_what_is_too_old_is_forgotten():
    backlog = Backlog(2**20)
    for time_ns in range(10):
        backlog.append(heard(time_ns))
    backlog.forget(7)
    assert (backlog.first_ns, backlog.dropped) == (7, 0)
    backlog.forget(100)
    assert backlog.first_ns is None
    with pytest.raises(IndexError):
        backlog.pop()


def test_the_newest_of_each_topic_said_seldom_is_known_once_it_has_left():
    backlog = Backlog(2**20)
    for time_ns, (topic, name) in enumerate(
        [
            (TARGET, ""),
            (CAMERA_POSE, "left"),
            (CAMERA_POSE, "right"),
            (SHAPE, ""),
            (TARGET, ""),
            (LOG, ""),
            (TARGET, ""),
        ]
    ):
        backlog.append(heard(time_ns, topic, key=topic.named(name).key))
    assert backlog.newest == {}
    backlog.pop()
    assert {key: one.log_time_ns for key, one in backlog.newest.items()} == {"target": 0}
    backlog.forget(6)
    assert {key: one.log_time_ns for key, one in backlog.newest.items()} == {
        "target": 4,
        "camera/left/pose": 1,
        "camera/right/pose": 2,
    }
