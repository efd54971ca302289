"""What the controller carries from cycle to cycle survives its bytes: whoever goes on from there does the same, bit for bit."""

import copy
import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.cycle import Inputs, LoopState
from messaging.errors import CodecError
from messaging.shape import NodalPoints
from messaging.snapshot import freeze


def same(one, other):
    """Equal to the last bit, arrays and all."""
    return freeze(one) == freeze(other)


def thawed(state):
    return LoopState.from_bytes(state.to_bytes())


@pytest.mark.parametrize("cycles", [0, 1, 50])
def test_a_state_comes_back_whatever_it_holds(paper_bench, homed, tracking, cycles):
    for bench in (paper_bench, homed, tracking):
        for _ in range(cycles):
            bench.cycle(())
        assert same(thawed(bench.state), bench.state)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(0, 60), max_size=3), st.sampled_from(["hold", "arm", "relax", "stop", "status"]))
def test_a_run_that_goes_on_from_memory_is_the_run_itself(tracking_once, gaps, action):
    bench = copy.deepcopy(tracking_once)
    seen = []
    step = bench.loop.step
    bench.loop = dataclasses.make_dataclass("Loop", ["step"])(
        lambda state, inputs: seen.append((state, inputs)) or step(state, inputs)
    )
    bench.do(action, 0.3)
    state = seen[0][0]
    recall_at = {sum(gaps[: n + 1]) for n in range(len(gaps))}
    for index, (live, inputs) in enumerate(seen):
        assert isinstance(inputs, Inputs)
        assert same(state, live)
        if index in recall_at:
            state = thawed(state)
        state, _ = step(state, inputs)


def test_a_memory_of_something_else_is_refused():
    other = freeze(NodalPoints(names=("tip",), arc_mm=[80.0]))
    with pytest.raises(CodecError, match="holds a NodalPoints, not the controller's memory"):
        LoopState.from_bytes(other)
