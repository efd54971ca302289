import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.simulated.robot.errors import RobotBuildError, RobotInputError
from drivers.simulated.robot.robot import SimulatedRobot, static_shape
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings, ideal

BENCH = SimulatedRobotSettings()
DT_S = 0.01
ZERO = np.zeros(4)


def bench(**changes):
    return SimulatedRobot(msgspec.structs.replace(BENCH, **changes))


def settle(robot, servo_mm, steps=150):
    for _ in range(steps):
        state = robot.step(servo_mm, 0.0, 0.05)
    return state


def tip(state):
    return state.shape.centreline_mm[-1]


def sweep(robot, first_mm, last_mm, steps=60):
    """Tips on the way of the first servo from one displacement to another."""
    return np.array([tip(robot.step([d, 0, 0, 0], 0.0, 0.05)) for d in np.linspace(first_mm, last_mm, steps)])


def test_a_pulled_pair_bends_the_robot_towards_its_first_tendon():
    robot = SimulatedRobot(ideal(BENCH))
    for servo, heading_deg in enumerate((0, 90, 45, 135)):
        x, y, _ = tip(settle(robot, 3.0 * np.eye(4)[servo], steps=20))
        assert np.hypot(x, y) > 5.0
        # a pull on a distal pair is shared with the section before, whose own pairs hold it
        assert np.degrees(np.arctan2(y, x)) == pytest.approx(heading_deg, abs=1.0)


def test_the_stage_carries_the_whole_robot():
    inserted = SimulatedRobot(BENCH).step(ZERO, 25.0, DT_S).shape.centreline_mm
    np.testing.assert_allclose(inserted[0], [0, 0, 25.0], atol=1e-9)
    np.testing.assert_allclose(
        inserted - SimulatedRobot(BENCH).step(ZERO, 0.0, DT_S).shape.centreline_mm, [[0, 0, 25.0]] * 81
    )


def test_repeated_steps_come_to_rest_at_the_static_shape_of_their_tensions():
    state = settle(bench(friction_coefficient=0.0), [2.0, -1.0, 1.0, 2.0])
    expected = static_shape(BENCH, state.tendon_tension_N)
    np.testing.assert_allclose(state.shape.centreline_mm, expected.centreline_mm, atol=0.05)


def test_a_robot_at_rest_stays_where_it_is():
    robot = SimulatedRobot(BENCH)
    rest = tip(settle(robot, [3.0, 1.0, -2.0, 0.0]))
    np.testing.assert_allclose(tip(settle(robot, [3.0, 1.0, -2.0, 0.0])), rest, atol=1e-3)


@pytest.mark.parametrize(
    ("servo_mm", "base", "end"), [([8.0, 0.0, 5.6, -5.6], 0, 40), ([0.0, 0.0, 8.0, -8.0], 40, 80)]
)
def test_each_section_bends_by_80_degrees_within_8_mm_of_travel(servo_mm, base, end):
    tangents = settle(bench(), servo_mm).shape.tangents
    assert np.degrees(np.arccos(tangents[base] @ tangents[end])) > 80


def test_friction_makes_the_way_back_another_one():
    there_and_back = {}
    for coefficient in (0.0, 0.15):
        robot = bench(friction_coefficient=coefficient, backlash_mm=0.0, damping_s=0.0)
        sweep(robot, 0.0, 5.0)
        back = sweep(robot, 5.0, -5.0, 101)
        there = sweep(robot, -5.0, 5.0, 101)
        there_and_back[coefficient] = np.abs(there[20:80] - back[::-1][20:80])[:, 0].max()
    assert there_and_back[0.0] < 0.01
    assert there_and_back[0.15] > 1.0


def test_friction_keeps_its_place_when_nothing_moves():
    robot = bench(backlash_mm=0.0)
    sweep(robot, 0.0, 5.0)
    from_below = tip(settle(robot, [2.5, 0, 0, 0]))
    sweep(robot, 2.5, -5.0)
    from_above = tip(settle(robot, [2.5, 0, 0, 0]))
    assert np.linalg.norm(from_below - from_above) > 1.0


def test_play_swallows_small_reversals_entirely():
    robot = bench(backlash_mm=0.2)
    sweep(robot, 0.0, 3.0)
    rest = tip(settle(robot, [3.0, 0, 0, 0]))
    np.testing.assert_allclose(tip(settle(robot, [2.81, 0, 0, 0])), rest, atol=1e-3)
    assert np.linalg.norm(tip(settle(robot, [2.4, 0, 0, 0])) - rest) > 0.05


def test_friction_and_play_never_make_the_tip_jump():
    robot = bench()
    sweep(robot, 0.0, 4.0, 200)
    steps = np.diff(np.concatenate([sweep(robot, 4.0, -4.0, 400), sweep(robot, -4.0, 4.0, 400)]), axis=0)
    assert np.linalg.norm(steps, axis=1).max() < 0.3


def test_servo_load_is_the_difference_of_the_pair():
    state = settle(bench(), [4.0, 0.0, 0.0, 0.0])
    pairs = state.tendon_tension_N.reshape(4, 2)
    np.testing.assert_allclose(state.servo_load_N, pairs[:, 0] - pairs[:, 1])
    assert state.servo_load_N[0] > 1.0


def test_damping_is_the_time_constant_of_a_released_robot():
    section = msgspec.structs.replace(
        BENCH.sections[0], stiffness_variation=0.0, precurvature_per_mm=(0.0, 0.0)
    )
    # tendons this soft pull with a force that the motion hardly changes
    soft = {"tendon_compliance_mm_per_N": 1e6, "pretension_N": 0.0, "damping_s": 0.5}
    robot = SimulatedRobot(msgspec.structs.replace(ideal(BENCH), sections=(section,), **soft))
    pulled = tip(settle(robot, [1e6, 0.0], 200))[0]
    for _ in range(500):
        released = tip(robot.step([0.0, 0.0], 0.0, 0.001))[0]
    assert released / pulled == pytest.approx(np.exp(-1), abs=0.02)


@settings(max_examples=12, deadline=None)
@given(
    st.lists(st.lists(st.floats(-20, 20), min_size=4, max_size=4), min_size=1, max_size=12),
    st.floats(1e-4, 1.0),
)
def test_wild_inputs_give_finite_shapes_and_pulling_tendons(commands, dt_s):
    robot = SimulatedRobot(BENCH)
    for command in commands:
        state = robot.step(command, 0.0, dt_s)
        assert np.isfinite(state.shape.centreline_mm).all()
        assert (state.tendon_tension_N >= 0).all()
        np.testing.assert_allclose(np.linalg.norm(state.shape.tangents, axis=1), 1.0, atol=1e-6)
        assert (np.linalg.norm(np.diff(state.shape.centreline_mm, axis=0), axis=1) <= 1.0 + 1e-6).all()


def test_the_same_commands_give_the_same_bytes():
    commands = np.random.default_rng(5).uniform(-4, 4, (40, 4))
    first, second = SimulatedRobot(BENCH), SimulatedRobot(BENCH)
    for command in commands:
        one, other = first.step(command, 0.0, DT_S), second.step(command, 0.0, DT_S)
        assert one.shape.centreline_mm.tobytes() == other.shape.centreline_mm.tobytes()
        assert one.tendon_tension_N.tobytes() == other.tendon_tension_N.tobytes()


@pytest.mark.parametrize(
    ("servo_mm", "insertion_mm", "dt_s", "named"),
    [
        (np.zeros(3), 0.0, DT_S, "servo_displacement_mm"),
        ([np.inf, 0, 0, 0], 0.0, DT_S, "servo_displacement_mm"),
        (ZERO, np.nan, DT_S, "insertion_mm"),
        (ZERO, 0.0, 0.0, "dt_s"),
        (ZERO, 0.0, np.nan, "dt_s"),
    ],
)
def test_unusable_input_is_refused_by_name_and_changes_nothing(servo_mm, insertion_mm, dt_s, named):
    robot = SimulatedRobot(BENCH)
    before = robot.state
    with pytest.raises(RobotInputError, match=named):
        robot.step(servo_mm, insertion_mm, dt_s)
    assert robot.state is before


def test_a_tendon_without_a_partner_is_refused():
    section = SectionSettings(tendon_angles_deg=(90.0, -30.0, 210.0))
    with pytest.raises(RobotBuildError, match="section 1 has 3 tendons"):
        SimulatedRobot(SimulatedRobotSettings(sections=(section,)))


def test_settings_out_of_bounds_or_unknown_are_refused():
    for bad in ({"backlash_mm": -1}, {"stiction": 1}, {"sections": []}):
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert(bad, SimulatedRobotSettings)
