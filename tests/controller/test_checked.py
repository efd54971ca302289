"""What comes into a cycle and is no number, or of the wrong size, gets no further."""

import dataclasses

import numpy as np
import pytest

from controller.checked import checked
from controller.cycle import Inputs
from controller.errors import ClockError
from controller.supervisor import Mode

PERIOD_S = 0.005
NAN, INF = float("nan"), float("inf")
AXES = {
    "displacement_mm": 4,
    "displacement_mm_s": 4,
    "current_ma": 5,
    "temperature_c": 5,
    "voltage_v": 5,
    "hardware_error": 5,
}


def garbled(bench, field, value):
    """The bench's servos from now on report this."""
    state = bench.servos.state
    bench.servos.state = lambda: dataclasses.replace(state(), **{field: value})


@pytest.mark.parametrize("spoilt", [NAN, INF, -INF, "short", "long"])
@pytest.mark.parametrize("field", AXES)
def test_a_reading_that_is_of_no_use_is_a_lost_drive_that_names_the_field(tracking, field, spoilt):
    value = np.zeros(AXES[field] + {"short": -1, "long": 1}.get(spoilt, 0))
    if isinstance(spoilt, float):
        value[1] = spoilt
    garbled(tracking, field, value)
    (moment,), _ = tracking.run(PERIOD_S)
    assert moment.state.supervision.fault.code == "drive_lost"
    assert f"the tendon drive reports {field} = {value.tolist()}; it must be" in moment.outputs.reason
    assert moment.outputs.release
    assert moment.outputs.command_mm is None


@pytest.mark.parametrize("field", ["insertion_mm", "insertion_mm_s"])
def test_so_is_one_with_a_stage_that_is_nowhere(tracking, field):
    garbled(tracking, field, NAN)
    tracking.run(PERIOD_S)
    assert tracking.state.supervision.reason == f"the tendon drive reports {field} = nan; it must be finite"


def test_in_idle_it_is_said_and_nothing_can_be_begun(paper_bench):
    paper_bench.run(0.2)
    garbled(paper_bench, "insertion_mm", INF)
    assert "no tendon drive: the tendon drive reports insertion_mm = inf" in paper_bench.do("home").reason
    assert paper_bench.state.mode is Mode.IDLE
    assert "insertion_mm = inf" in paper_bench.do("status").reason


@pytest.mark.parametrize("age_s", [NAN, INF, -INF, -0.01])
def test_a_shape_of_no_age_is_distrusted(tracking, age_s):
    step = tracking.loop.step

    def aged(state, inputs):
        sighting = inputs.sighting and dataclasses.replace(inputs.sighting, age_s=age_s)
        return step(state, dataclasses.replace(inputs, sighting=sighting))

    tracking.loop.step = aged
    tracking.run(0.2)
    assert tracking.state.mode is Mode.WAITING
    assert f"shape is said to be {age_s} s old" in tracking.state.distrusted


@pytest.mark.parametrize(("now_s", "dt_s"), [(NAN, 0.005), (INF, 0.005), (1.0, 0.0), (1.0, -0.1), (1.0, NAN)])
def test_nothing_can_be_done_without_a_clock(homed, now_s, dt_s):
    inputs = Inputs(now_s=now_s, dt_s=dt_s, sighting=None, drive=None, absence="")
    with pytest.raises(ClockError, match=f"now_s = {now_s} s, dt_s = {dt_s} s"):
        homed.loop.step(homed.state, inputs)


def test_what_is_sound_passes_as_it_is(homed):
    inputs = Inputs(now_s=1.0, dt_s=0.005, sighting=None, drive=homed.servos.state(), absence="")
    assert checked(inputs, 4, 5) is inputs
