"""Every message survives its bytes, and nothing that is not a message passes for one."""

import contextlib
import dataclasses
from enum import StrEnum

import numpy as np
import pytest
from google.protobuf.descriptor import FieldDescriptor
from hypothesis import given, settings
from hypothesis import strategies as st

from messaging.checked import FloatArray
from messaging.control import Target
from messaging.errors import CodecError, InvalidMessageError
from messaging.frames import Frame
from messaging.message import Message
from messaging.shape import Flag, NodalPoints, ShapeEstimate
from messaging.topics import SERVICES, TOPICS
from messaging.views import View

PLAIN_TYPES = sorted(
    {
        kind
        for kind in [topic.type for topic in TOPICS]
        + [s.request for s in SERVICES]
        + [s.reply for s in SERVICES]
        if not issubclass(kind, View)
    },
    key=lambda kind: kind.__name__,
)
VIEW_TYPES = sorted(
    {topic.type for topic in TOPICS if issubclass(topic.type, View)}, key=lambda kind: kind.__name__
)

INTEGERS = {
    FieldDescriptor.TYPE_INT64: st.integers(-(2**63), 2**63 - 1),
    FieldDescriptor.TYPE_UINT64: st.integers(0, 2**64 - 1),
}
NUMBER = st.floats(allow_nan=False, allow_infinity=False)
TEXT = st.text(st.characters(codec="utf-8"), max_size=8)


@st.composite
def messages(draw, kind: type[Message]) -> Message:
    """A message of this type with any content that the type allows."""
    if kind is Frame:
        return Frame(camera=draw(TEXT), capture_time_ns=draw(st.integers(0, 2**62)), jpeg=draw(st.binary()))
    lowest = 1 if kind in (NodalPoints, Target) else 0
    sizes: dict[str, int] = {}
    values = {}
    for field in dataclasses.fields(kind):
        shape = tuple(
            size if isinstance(size, int) else sizes.setdefault(size, draw(st.integers(lowest, 3)))
            for size in field.metadata.get("shape", ())
        )
        values[field.name] = draw(_value(kind, field, shape))
    return kind(**values)


def _value(kind, field, shape):
    if (kind, field.name) in SPECIAL:
        return SPECIAL[kind, field.name](*shape)
    if field.type is FloatArray:
        count = int(np.prod(shape))
        return st.lists(NUMBER, min_size=count, max_size=count).map(lambda flat: np.reshape(flat, shape))
    if shape:
        return st.lists(TEXT, min_size=shape[0], max_size=shape[0]).map(tuple)
    if isinstance(field.type, type) and issubclass(field.type, StrEnum):
        return st.sampled_from(field.type)
    if field.type is int:
        return INTEGERS[kind.protobuf.DESCRIPTOR.fields_by_name[field.name].type]
    return {float: NUMBER, str: TEXT, bool: st.booleans(), bytes: st.binary(max_size=8)}[field.type]


def _different_names(count):
    return st.lists(TEXT.filter(bool), min_size=count, max_size=count, unique=True).map(tuple)


def _increasing(count):
    steps = st.lists(st.floats(0.001, 1e6), min_size=count - 1, max_size=count - 1)
    return steps.map(lambda each: np.concatenate([[0.0], np.cumsum(each)]))


def _weights(count):
    return st.lists(st.floats(0.5, 10), min_size=count, max_size=count).map(np.array)


SPECIAL = {
    (ShapeEstimate, "flags"): lambda count: st.lists(
        st.sampled_from(Flag), min_size=count, max_size=count
    ).map(tuple),
    (NodalPoints, "names"): _different_names,
    (NodalPoints, "arc_mm"): _increasing,
    (Target, "node_names"): _different_names,
    (Target, "time_s"): _increasing,
    (Target, "weights"): _weights,
    (Target, "repeat_from_s"): lambda: st.just(0.0),
}


@pytest.mark.parametrize("kind", PLAIN_TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_bytes_carry_everything(kind, data):
    message = data.draw(messages(kind))
    again = kind.from_bytes(message.to_bytes())
    assert again == message
    assert again.to_bytes() == message.to_bytes()


@pytest.mark.parametrize("kind", PLAIN_TYPES + VIEW_TYPES, ids=lambda kind: kind.__name__)
@settings(deadline=None)
@given(noise=st.binary(max_size=64))
def test_noise_is_a_message_or_a_typed_error(kind, noise):
    with contextlib.suppress(CodecError, InvalidMessageError):
        kind.from_bytes(noise)


@pytest.mark.parametrize("kind", PLAIN_TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_damage_is_a_message_or_a_typed_error(kind, data):
    damaged = bytearray(data.draw(messages(kind)).to_bytes())
    if damaged:
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(CodecError, InvalidMessageError):
        kind.from_bytes(bytes(damaged[: data.draw(st.integers(0, len(damaged)))]))
