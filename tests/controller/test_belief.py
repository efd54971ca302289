"""What is learnt of a robot that is not its nominal model: gains, bias and lost motion; and what must not be learnt."""

import numpy as np
import pytest

from controller.belief import Axes, BeliefSettings, Learning
from controller.errors import ControllerSetupError
from controller.identified import Drawing, IdentifiedSettings
from controller.kinematics import Kinematics
from controller.law import Measurement
from controller.lost_motion import engaged_after

ARC = np.array([20.0, 40.0, 60.0, 80.0])
KINEMATICS = Kinematics([40.0, 40.0], np.radians([[0, 90], [45, 135]]), [4.0, 4.0])
UNKNOWN = np.full(5, np.nan)


def measured(node_mm, capture_s):
    return Measurement(
        capture_s=capture_s,
        arc_mm=ARC,
        node_mm=node_mm,
        covariance_mm2=np.tile(1e-4 * np.eye(3), (len(ARC), 1, 1)),
        led=np.array([3]),
    )


class Robot:
    """Constant curvature with gains, a bias and play of its own."""

    def __init__(self, gain=1.0, bias_mm=(0.0, 0.0, 0.0, 0.0), play_mm=0.0):
        self.gain, self.bias_mm, self.play_mm = gain, np.append(bias_mm, 0.0), play_mm
        self._felt_mm = np.zeros(5)

    def at(self, position_mm):
        play = np.array([self.play_mm] * 4 + [0.0]) / 2
        self._felt_mm = np.clip(self._felt_mm, position_mm - play, position_mm + play)
        scale = np.append(np.full(4, self.gain), 1.0)
        return KINEMATICS.nodes_mm(scale * self._felt_mm + self.bias_mm, ARC)


def path(seconds, rate_hz=30):
    """Positions (n, 5) of axes that go round and turn round."""
    time = np.arange(0, seconds, 1 / rate_hz)[:, None]
    swing = np.array([1.5, 1.4, 0.9, 1.0]) * np.sin(2 * np.pi * time / np.array([5.0, 6.0, 4.0, 7.0]))
    return np.column_stack([swing, 5 + 0 * time]), time[:, 0]


def learn(robot, seconds=16.0, settings=None, seed=1, begin=None):
    learning = Learning(settings or BeliefSettings(), KINEMATICS)
    random = np.random.default_rng(seed)
    positions, times = path(seconds)
    engaged = np.zeros(5)
    first = measured(robot.at(positions[0]), times[0])
    belief = begin or learning.begin(first, Axes(position_mm=positions[0], engaged=engaged), UNKNOWN)
    misses = []
    for before, position, time in zip(positions, positions[1:], times[1:], strict=False):
        width = learning.lost_motion_mm(belief)
        engaged = engaged_after(engaged, position - before, width, 0.05)
        axes = Axes(position_mm=position, engaged=engaged)
        truth = robot.at(position)
        misses.append(learning.nodes(belief, learning.felt_mm(belief, axes), ARC)[0][-1] - truth[-1])
        noisy = truth + random.normal(scale=0.01, size=truth.shape)
        belief = learning.corrected(belief, measured(noisy, time), axes)
    return learning, belief, np.linalg.norm(misses, axis=1), axes


def jacobian_error(learning, belief, axes, robot):
    felt = learning.felt_mm(belief, axes)
    _, believed = learning.nodes(belief, felt, ARC)
    scale = np.append(np.full(4, robot.gain), 1.0)
    _, true = KINEMATICS.nodes_and_jacobian(scale * felt + robot.bias_mm, ARC)
    true = true * scale
    return np.linalg.norm(believed[-1] - true[-1]) / np.linalg.norm(true[-1])


@pytest.mark.parametrize("gain", [0.7, 1.3])
def test_gains_are_learnt_far_better_than_the_nominal_model(gain):
    robot = Robot(gain=gain, bias_mm=(0.3, -0.2, 0.1, 0.2))
    learning, belief, misses, axes = learn(robot)
    nominal = learning.begin(measured(robot.at(axes.position_mm), 0.0), axes, UNKNOWN)
    learnt, unlearnt = (jacobian_error(learning, b, axes, robot) for b in (belief, nominal))
    assert learnt < 0.3 * unlearnt
    assert misses[-150:].mean() < 0.05


def test_lost_motion_is_learnt_from_turning_round():
    _, wide, _, _ = learn(Robot(play_mm=0.6), seconds=40)
    learning, none, _, _ = learn(Robot(play_mm=0.0), seconds=40)
    assert learning.lost_motion_mm(wide)[:4].mean() > 0.37
    assert learning.lost_motion_mm(none)[:4].mean() < 0.2
    assert learning.lost_motion_mm(wide)[4] == 0.0


def test_what_homing_found_is_where_learning_begins():
    learning = Learning(BeliefSettings(lost_motion_mm=0.3), KINEMATICS)
    resting = Axes(position_mm=np.zeros(5), engaged=np.zeros(5))
    found = np.array([0.1, np.nan, 0.5, np.nan, np.nan])
    belief = learning.begin(measured(KINEMATICS.nodes_mm(np.zeros(5), ARC), 0.0), resting, found)
    np.testing.assert_allclose(learning.lost_motion_mm(belief), [0.1, 0.3, 0.5, 0.3, 0.0])


def test_a_blow_moves_the_offsets_and_leaves_the_gains_nearly_alone():
    robot = Robot(gain=0.8)
    learning, belief, _, axes = learn(robot, seconds=10)
    hit = measured(robot.at(axes.position_mm) + np.array([6.0, -4.0, 1.0]), 10.1)
    after = learning.corrected(belief, hit, axes)
    felt = learning.felt_mm(after, axes)
    np.testing.assert_allclose(learning.nodes(after, felt, ARC)[0], hit.node_mm, atol=0.3)
    known = slice(0, 20)
    assert np.abs(after.mean[known] - belief.mean[known]).max() < 0.1


def test_nonsense_cannot_drive_what_is_believed_beyond_its_bounds():
    settings = BeliefSettings()
    learning, belief, _, axes = learn(Robot(), seconds=2)
    random = np.random.default_rng(3)
    for step in range(100):
        belief = learning.corrected(
            belief, measured(random.normal(scale=60, size=(4, 3)), 2 + step / 30), axes
        )
    assert np.isfinite(belief.mean).all()
    assert np.abs(belief.mean[:16]).max() <= settings.bound + 1e-12
    assert np.abs(belief.mean[16:20]).max() <= 4 * settings.bias_rad + 1e-12
    assert (learning.lost_motion_mm(belief) >= 0).all()
    assert np.linalg.eigvalsh(belief.covariance).min() > -1e-9


def test_what_is_not_confirmed_is_forgotten():
    settings = BeliefSettings(memory_s=10.0)
    learning, belief, _, axes = learn(Robot(gain=0.7), seconds=8, settings=settings)
    later = measured(learning.nodes(belief, learning.felt_mm(belief, axes), ARC)[0], 8 + 100.0)
    after = learning.corrected(belief, later, axes)
    assert np.abs(after.mean[:16]).max() < 0.5 * np.abs(belief.mean[:16]).max()
    sigma = np.sqrt(np.diag(after.covariance))[:20]
    assert (sigma <= np.append(np.full(16, settings.gain_sigma), np.full(4, settings.bias_rad)) + 1e-9).all()


def test_other_points_keep_what_was_learnt_of_the_robot():
    learning, belief, _, axes = learn(Robot(gain=0.7), seconds=6)
    fewer = Measurement(
        capture_s=21.0,
        arc_mm=ARC[2:],
        node_mm=Robot(gain=0.7).at(axes.position_mm)[2:],
        covariance_mm2=np.zeros((2, 3, 3)),
        led=np.array([1]),
    )
    anew = learning.corrected(belief, fewer, axes)
    np.testing.assert_array_equal(anew.mean[:20], belief.mean[:20])
    felt = learning.felt_mm(anew, axes)
    np.testing.assert_allclose(learning.nodes(anew, felt, ARC[2:])[0], fewer.node_mm, atol=1e-9)


def test_believed_points_move_as_the_believed_jacobian_says():
    learning, belief, _, axes = learn(Robot(gain=0.8, play_mm=0.3), seconds=4)
    felt = learning.felt_mm(belief, axes)
    _, jacobian = learning.nodes(belief, felt, ARC)
    for axis, unit in enumerate(np.eye(5) * 1e-6):
        ahead, behind = (learning.nodes(belief, felt + way * unit, ARC)[0] for way in (1, -1))
        np.testing.assert_allclose(jacobian[..., axis], (ahead - behind) / 2e-6, atol=1e-5)


DRAWING = Drawing(
    section_length_mm=(40.0, 40.0),
    angle_deg=((0.0, 90.0), (45.0, 135.0)),
    pitch_radius_mm=(4.0, 4.0),
    coupling=1.0,
    mm_per_rad=(5.0, 5.0, 5.0, 5.0, 1.0),
)


def identified_settings(**changes):
    values = {
        "date": "today",
        "drawing": DRAWING,
        "gain": tuple(tuple(0.1 * (row == column) for column in range(4)) for row in range(4)),
        "gain_sigma": ((0.02,) * 4,) * 4,
        "bias_rad": (0.01, 0.02, 0.03, 0.04),
        "bias_sigma_rad": (0.02,) * 4,
        "lost_motion_mm": (0.4, 0.5, 0.6, 0.7),
        "lost_motion_sigma_mm": (0.05,) * 4,
        "stage_gain": (0.03,),
        "stage_gain_sigma": (0.01,),
    }
    return IdentifiedSettings(**{**values, **changes})


def test_what_was_identified_is_where_belief_begins_but_homing_knows_lost_motion_better():
    learning = Learning(BeliefSettings(), KINEMATICS, identified_settings().stacked(KINEMATICS))
    first, axes = measured(Robot().at(np.zeros(5)), 0.0), Axes(position_mm=np.zeros(5), engaged=np.zeros(5))
    found = np.array([np.nan, 0.2, np.nan, np.nan, np.nan])
    belief = learning.begin(first, axes, found)
    np.testing.assert_array_equal(belief.mean[:16].reshape(4, 4), 0.1 * np.eye(4))
    np.testing.assert_array_equal(belief.mean[16:25], [0.01, 0.02, 0.03, 0.04, 0.03, 0.4, 0.2, 0.6, 0.7])
    np.testing.assert_array_equal(belief.nominal[:25], belief.mean[:25])


def test_how_well_the_mean_over_all_places_is_known_does_not_keep_a_law_from_learning_what_is_so_here():
    known = identified_settings(bias_sigma_rad=(0.02, 0.02, 0.3, 0.02))
    learning = Learning(BeliefSettings(), KINEMATICS, known.stacked(KINEMATICS))
    first = measured(Robot().at(np.zeros(5)), 0.0)
    belief = learning.begin(first, Axes(position_mm=np.zeros(5), engaged=np.zeros(5)), np.full(5, np.nan))
    sigma = np.sqrt(np.diag(belief.covariance))[:25]
    np.testing.assert_allclose(sigma, [0.25] * 16 + [0.15, 0.15, 0.3, 0.15] + [0.1] + [0.15] * 4)


def test_a_law_that_knows_its_robot_is_right_from_its_first_shapes():
    gain, settings = 0.7, BeliefSettings()
    known = identified_settings(
        gain=tuple(tuple((gain - 1) * (row == column) for column in range(4)) for row in range(4)),
        bias_rad=(0.0,) * 4,
        lost_motion_mm=(0.0,) * 4,
        stage_gain=(0.0,),
    )
    learning = Learning(settings, KINEMATICS, known.stacked(KINEMATICS))
    robot, positions = Robot(gain), path(0.5)[0]
    start = Axes(position_mm=positions[0], engaged=np.zeros(5))
    belief = learning.begin(measured(robot.at(positions[0]), 0.0), start, np.zeros(5))
    ignorant = Learning(settings, KINEMATICS).begin(measured(robot.at(positions[0]), 0.0), start, np.zeros(5))
    missed = [
        np.linalg.norm(learning.nodes(one, positions[-1], ARC)[0] - robot.at(positions[-1]), axis=1).max()
        for one in (belief, ignorant)
    ]
    assert missed[0] < 1e-6
    assert missed[1] > 1.0


@pytest.mark.parametrize(
    "changes", [{"lost_motion_mm": (0.4,) * 3}, {"stage_gain": ()}, {"bias_sigma_rad": (0.02,) * 5}]
)
def test_what_was_identified_of_another_robot_is_refused(changes):
    with pytest.raises(
        ControllerSetupError, match=r"controller\.identified is of another robot: this one has 4 bends"
    ):
        identified_settings(**changes).stacked(KINEMATICS)


def test_gains_must_be_square():
    with pytest.raises(ValueError, match="gain must have 4 rows of 4 numbers"):
        identified_settings(gain=((0.0,) * 4,) * 3)
