"""The stage keeps its name for every place, whatever is homed; where its reading cannot be, nothing moves."""

import numpy as np
import pytest

from messaging.control import Action, ActionRequest

PERIOD_S = 0.005


@pytest.mark.parametrize(("stands_mm", "travel"), [(45.0, "45.000 mm, travel 0 to 40"), (-2.0, "-2.000 mm")])
@pytest.mark.parametrize("order", ["home", "jog"])
def test_a_stage_beyond_its_travel_is_reported_and_not_renamed(paper_bench, order, stands_mm, travel):
    paper_bench.servos.position_mm[-1] = stands_mm
    paper_bench.run(0.2)
    request = ActionRequest(action=Action(order), axis="stage", distance_mm=-1.0)
    (moment,), (reply,) = paper_bench.run(PERIOD_S, request)
    assert not reply.accepted
    assert f"the stage stands at {travel}" in reply.reason
    assert moment.state.mode == "idle"
    assert moment.outputs.zero_mm is None


def test_a_stage_that_settled_a_little_beyond_is_led_back_and_keeps_its_name(paper_bench):
    paper_bench.servos.position_mm[-1] = -0.3
    (moment,), (reply,) = paper_bench.run(
        PERIOD_S, ActionRequest(action=Action.JOG, axis="1", distance_mm=1.0)
    )
    assert reply.accepted
    assert moment.outputs.zero_mm[-1] == -0.3
    assert moment.outputs.command_mm[-1] == 0.0


def test_homing_does_not_call_the_stage_s_standing_error_zero(paper_bench):
    paper_bench.servos.position_mm[-1] = 10.0
    obey = paper_bench.servos.obey

    def sags(outputs):
        """A load holds the stage 0.2 mm behind its goal."""
        obey(outputs)
        if outputs.command_mm is not None:
            paper_bench.servos.position_mm[-1] = outputs.command_mm[-1] - 0.2

    paper_bench.servos.obey = sags
    for _ in range(2):
        paper_bench.home()
        assert np.sum(paper_bench.servos.zero_mm[-1] if np.ndim(paper_bench.servos.zero_mm) else 0.0) == 0.0
        assert paper_bench.state.command_mm[-1] == 10.0
        assert paper_bench.do("hold").accepted
