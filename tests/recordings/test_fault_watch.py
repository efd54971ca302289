"""A fault is noticed once, when it begins."""

from messaging.control import ControllerState, State
from messaging.session import Received
from messaging.topics import CONTROLLER_STATE, SHAPE
from recordings.backlog import Heard
from recordings.fault_watch import FaultWatch


def heard(state, reason="", topic=CONTROLLER_STATE):
    return said(ControllerState.protobuf(state=state, reason=reason).SerializeToString(), topic)


def said(payload, topic=CONTROLLER_STATE):
    return Heard(topic, Received(key=topic.key, payload=payload, sequence=0, publish_time_ns=0, epoch=0), 0)


def reasons(*states):
    watch = FaultWatch()
    return [watch.begins(state) for state in states]


def test_a_fault_is_told_once_with_its_reason():
    fault = heard(State.FAULT, "servo 3 is hot")
    assert reasons(heard(State.IDLE), fault, fault, heard(State.IDLE), fault) == [
        None,
        "servo 3 is hot",
        None,
        None,
        "servo 3 is hot",
    ]


def test_one_that_was_there_already_does_not_begin():
    assert reasons(heard(State.FAULT), heard(State.FAULT)) == [None, None]


def test_the_word_alone_is_no_fault():
    told = heard(State.HOLD, "the servo says: fault")
    assert reasons(heard(State.IDLE), told, told) == [None, None, None]


def test_what_is_not_a_state_is_passed_over():
    fault = heard(State.FAULT, "hot")
    watch = FaultWatch()
    watch.begins(heard(State.IDLE))
    assert watch.begins(heard(State.FAULT, topic=SHAPE)) is None
    assert watch.begins(said(b"\xff fault")) is None
    assert watch.begins(fault) == "hot"
