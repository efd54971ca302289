"""Where a robot is led: within its reach, every axis with reversals, and nothing that is to be foreseen is fitted."""

import hypothesis
import numpy as np
from hypothesis import strategies as st

from calibration.robot_plan import Reach, planned

PAIRS = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.7, 0.7], [0, 0, -0.7, 0.7]])
ANGLES = np.radians([90, 210, 330])
SINGLE = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)


@hypothesis.given(st.floats(0.1, 20), st.integers(8, 30), st.integers(2, 8))
@hypothesis.settings(max_examples=25, deadline=None)
def test_no_pose_is_out_of_reach(tendon_mm, together, held_out):
    plan = planned(
        PAIRS, np.ones(4, bool), Reach(tendon_mm=tendon_mm, stage_mm=(1.0, 6.0)), together, held_out
    )
    for poses in (plan.alone_mm, plan.together_mm, plan.held_out_mm):
        assert np.abs(poses[:, :4]).max() <= tendon_mm * (1 + 1e-9)
        assert set(poses[:, 4]) <= {1.0, 6.0}
    assert len(plan.together_mm) + len(plan.held_out_mm) == together + held_out
    assert len(plan.held_out_mm) >= held_out


def test_each_axis_alone_goes_both_ways_and_back():
    plan = planned(PAIRS, np.ones(4, bool), Reach(tendon_mm=3.0, stage_mm=()), 16, 8)
    for axis in range(4):
        assert (plan.alone_mm[:, axis] == 3.0).any()
        assert (plan.alone_mm[:, axis] == -3.0).any()
    assert (plan.alone_mm[-1] == 0).all()
    assert ((plan.alone_mm != 0).sum(axis=1) <= 1).all()


def test_single_tendons_are_never_let_go_alone():
    plan = planned(SINGLE, np.zeros(3, bool), Reach(tendon_mm=3.0, stage_mm=()), 16, 8)
    assert plan.alone_mm.min() == 0.0
    assert plan.alone_mm.max() == 1.5
    np.testing.assert_allclose(plan.together_mm.sum(axis=1), 0.0, atol=1e-9)


def test_what_is_foreseen_is_not_among_what_is_fitted_and_bends_every_way():
    plan = planned(PAIRS, np.ones(4, bool), Reach(tendon_mm=3.0, stage_mm=(0.0,)), 16, 8)
    apart = np.abs(plan.held_out_mm[:, None] - plan.together_mm[None]).max(axis=2)
    assert apart.min() > 0.1
    assert (plan.held_out_mm[:, :4].max(axis=0) > 0.5).all()
    assert (plan.held_out_mm[:, :4].min(axis=0) < -0.5).all()
