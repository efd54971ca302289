"""What the operator orders keeps clear of forbidden regions on its way, wherever the robot has been led meanwhile."""

import copy
import dataclasses

import pytest

from controller.regions import Sphere
from controller.settings import ControllerSettings, JogSettings
from messaging.control import Action, ActionRequest

PERIOD_S = 0.005
LAMP = Sphere(name="lamp", centre_mm=(0.0, 18.0, 78.0), radius_mm=3.0)


@pytest.fixture(scope="module")
def homed_beside_a_lamp(stand_ins):
    settings = ControllerSettings(
        forbidden=(LAMP,), keep_clear_mm=2.0, jog=JogSettings(mm_s=5.0, at_most_mm=10.0)
    )
    robot = stand_ins["PaperRobot"](settings.kinematics(stand_ins["ROBOT"]), gain=1.0)
    bench = stand_ins["VirtualBench"](robot, settings)
    bench.home()
    return bench


@pytest.fixture
def bench(homed_beside_a_lamp):
    """Homed, with a lamp at its side that it must not come near to."""
    return copy.deepcopy(homed_beside_a_lamp)


def lead_to_the_other_side(bench):
    """From where the straight way to the right leads past the lamp, too near to it."""
    for axis, distance_mm in (("1", -1.6), ("2", 1.6)):
        assert bench.jog(axis, distance_mm, 1.0).accepted
    assert bench.node_mm[1][0] < -12.0


def test_arming_looks_at_the_way_from_where_the_robot_is_now(bench, stand_ins):
    assert bench.run(PERIOD_S, stand_ins["pose"]((14.0, 14.0, 78.0)))[1][0].accepted
    near = copy.deepcopy(bench)
    assert near.do("arm").accepted
    lead_to_the_other_side(bench)
    reply = bench.do("arm")
    assert not reply.accepted
    assert "target pose: on the straight way to its beginning the robot would be" in reply.reason
    assert "region lamp" in reply.reason
    assert bench.state.mode == "hold"


def test_arming_looks_at_the_way_to_where_the_path_goes_on(bench, stand_ins):
    """Its beginning could be reached, but it was held at the far end."""
    line = stand_ins["led"]([0.0, 2.0], [[-14.0, 10.0, 78.0], [14.0, 14.0, 78.0]], name="line")
    lead_to_the_other_side(bench)
    joined = copy.deepcopy(bench)
    joined.state = dataclasses.replace(joined.state, target=line, joined_s=2.0)
    bench.state = dataclasses.replace(bench.state, target=line)
    assert not joined.do("arm").accepted
    assert bench.do("arm").accepted


def test_a_target_beside_arm_is_what_is_looked_at(bench, stand_ins):
    assert bench.run(PERIOD_S, stand_ins["pose"]((14.0, 14.0, 78.0)))[1][0].accepted
    lead_to_the_other_side(bench)
    arm = ActionRequest(action=Action.ARM)
    _, replies = bench.run(PERIOD_S, stand_ins["pose"]((-12.0, 8.0, 78.0)), arm)
    assert [reply.accepted for reply in replies] == [True, True]


def test_a_jog_must_not_lead_nearer_to_a_region_than_the_robot_keeps_away(bench):
    reply = bench.jog("2", 2.2)
    assert not reply.accepted
    assert "on the way of this jog the robot would be" in reply.reason
    assert "region lamp" in reply.reason
    assert bench.state.mode == "ready"
    assert bench.jog("2", 0.5).accepted


def test_a_jog_may_lead_away_from_a_region_that_is_too_near(bench):
    command_mm = bench.state.command_mm.copy()
    command_mm[1] = 1.5
    bench.servos.position_mm = command_mm.copy()
    bench.state = dataclasses.replace(bench.state, command_mm=command_mm)
    assert not bench.jog("2", 0.1).accepted
    assert bench.jog("2", -0.3).accepted
