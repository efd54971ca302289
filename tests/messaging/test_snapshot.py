"""Snapshots give back exactly what was frozen, and never make anything but the data classes that the reader allows."""

import dataclasses
import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from messaging.errors import CodecError
from messaging.shape import Flag, NodalPoints
from messaging.snapshot import freeze, thaw

POINTS = NodalPoints(names=("a", "tip"), arc_mm=[0.1, 80.0])

PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.text(max_size=5)
    | st.binary(max_size=5)
    | st.sampled_from(list(Flag)),
    lambda inner: (
        st.lists(inner, max_size=3).map(tuple) | st.dictionaries(st.text(max_size=3), inner, max_size=3)
    ),
    max_leaves=10,
)


@given(PLAIN)
def test_plain_values_come_back(value):
    back = thaw(freeze(value), ("messaging",))
    assert back == value
    assert type(back) is type(value)


@given(
    arrays.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.bool_, np.uint8]),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
    )
)
def test_arrays_come_back_bit_for_bit(array):
    back = thaw(freeze(array), ())
    assert (back.dtype, back.shape, back.tobytes()) == (array.dtype, array.shape, array.tobytes())


def test_data_classes_come_back_with_what_they_hold():
    back = thaw(freeze({"here": (POINTS, Flag.TIP_UNSEEN, np.float64(0.1), -math.inf)}), ("messaging",))
    assert back == {"here": (POINTS, Flag.TIP_UNSEEN, 0.1, -math.inf)}


def test_what_cannot_be_kept_is_named():
    with pytest.raises(CodecError, match="cannot keep a function"):
        freeze({"law": freeze})
    with pytest.raises(CodecError, match="cannot keep a ndarray"):
        freeze(np.array([object()]))


@pytest.mark.parametrize(
    ("snapshot", "problem"),
    [
        (b"\xc1", "not a snapshot"),
        (freeze(POINTS), "allowed are classes of sensing"),
        (
            msgspec.msgpack.encode({"kind": "sensing.step:step", "fields": {}}),
            "neither a dataclass nor",
        ),
        (
            msgspec.msgpack.encode({"kind": "sensing.step:Gone", "fields": {}}),
            "does not fit this version",
        ),
        (
            msgspec.msgpack.encode({"kind": "sensing.gone:Gone", "fields": {}}),
            "there is no sensing.gone:Gone",
        ),
        (
            msgspec.msgpack.encode({"kind": "sensing.refined.refinement:Prior", "fields": {"x": 1}}),
            "does not fit",
        ),
        (msgspec.msgpack.encode({"kind": "os:system", "fields": {}}), "allowed are classes of sensing"),
        (
            msgspec.msgpack.encode({"kind": "array", "type": "O", "shape": [1], "data": b"12345678"}),
            "not kept",
        ),
        (
            msgspec.msgpack.encode({"kind": "array", "type": "<f8", "shape": [2], "data": b"12345678"}),
            "reshape",
        ),
        (msgspec.msgpack.encode({"no": "kind"}), "does not fit"),
    ],
)
def test_what_is_not_a_snapshot_of_ours_is_refused(snapshot, problem):
    with pytest.raises(CodecError, match=problem):
        thaw(snapshot, ("sensing",))


def test_a_snapshot_runs_nothing():
    @dataclasses.dataclass(frozen=True)
    class Mine:
        x: int

    with pytest.raises(CodecError, match="allowed are classes of messaging"):
        thaw(freeze(Mine(1)), ("messaging",))
