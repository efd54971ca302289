"""A robot of the model's own kind, seen with noise: every number is found again, and as exactly as is said."""

import numpy as np
import pytest

from calibration.errors import RobotPosesError
from calibration.robot_identification import Expected, Identification
from calibration.robot_model import Poses

ARC = np.array([20.0, 40.0, 60.0, 80.0])
RADIUS = 4.0


class Flat:
    """Two sections in small bends: nodal points are linear in the bends, so that nothing but algebra is under test."""

    bend_of_coordinates = np.linalg.inv(np.kron(RADIUS * np.array([[1.0, 0.0], [1.0, 1.0]]), np.eye(2)))
    coordinates_of_command = np.eye(4, 5)
    tendons = 4

    def bent(self, bend_rad, arc_mm):
        first, second = np.minimum(arc_mm, 40.0), np.maximum(arc_mm - 40.0, 0.0)
        side = np.stack([first**2 / 80 + second, second**2 / 80], axis=-1)
        xy = np.einsum("ks,nsd->nkd", side, bend_rad.reshape(-1, 2, 2))
        return np.concatenate([xy, np.broadcast_to(arc_mm[:, None], (*xy.shape[:2], 1))], axis=-1)

    def felt(self, position_mm, lost_motion_mm, engaged):
        felt, half = np.empty_like(position_mm), lost_motion_mm / 2
        now = -engaged * half
        for row, position in enumerate(position_mm):
            now = np.clip(now, position - half, position + half)
            felt[row] = now
        return felt


class Robot:
    """What is to be found."""

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self.gain = random.normal(0, 0.15, (4, 4))
        self.bias = random.normal(0, 0.03, (2, 4))
        self.stage = 0.02
        self.lost = random.uniform(0.2, 0.6, 4)
        self.engaged = random.uniform(-0.9, 0.9, (2, 4))

    def seen(self, run, position_mm, noise_mm, seed):
        model = Flat()
        felt = model.felt(position_mm, np.append(self.lost, 0.0), np.append(self.engaged[run], 0.0))
        turn = model.bend_of_coordinates @ (np.eye(4) + self.gain) @ model.coordinates_of_command
        nodes = model.bent(felt @ turn.T + self.bias[run], ARC)
        nodes[..., 2] += (1 + self.stage) * felt[:, -1:]
        nodes += np.random.default_rng(seed).normal(0, noise_mm, nodes.shape)
        sigma = np.full(nodes.shape[:2], noise_mm)
        return Poses(position_mm=position_mm, node_mm=nodes, sigma_mm=sigma, arc_mm=ARC)


def walk(seed, poses=20):
    """Positions (n, 5) that turn round often."""
    random = np.random.default_rng(seed)
    return np.column_stack([random.uniform(-3, 3, (poses, 4)), random.uniform(0, 5, poses)])


def found(robot, noise_mm=0.05, seed=0):
    runs = [robot.seen(run, walk(10 * seed + run), noise_mm, 10 * seed + run + 5) for run in (0, 1)]
    return Identification(Flat(), Expected(), ARC).identified(runs), runs


def test_every_number_of_a_robot_of_the_models_kind_is_found():
    robot = Robot(1)
    identified, _ = found(robot)
    np.testing.assert_allclose(identified.gain.value, robot.gain, atol=0.03)
    np.testing.assert_allclose(identified.bias_rad.value, robot.bias.mean(axis=0), atol=0.03)
    np.testing.assert_allclose(identified.lost_motion_mm.value, robot.lost, atol=0.05)
    np.testing.assert_allclose(identified.stage_gain.value, [robot.stage], atol=0.01)
    assert identified.rms_mm < 0.12


def test_deviations_are_as_large_as_they_are_said_to_be():
    scores = []
    for seed in range(4):
        robot = Robot(seed)
        identified, _ = found(robot, seed=seed)
        for estimate, truth in (
            (identified.gain, robot.gain),
            (identified.stage_gain, [robot.stage]),
            (identified.lost_motion_mm, robot.lost),
        ):
            scores.extend(np.ravel((estimate.value - truth) / estimate.sigma))
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.4


def test_poses_that_nobody_fitted_are_foreseen():
    robot = Robot(2)
    robot.bias[0] = robot.bias[1]
    robot.engaged[:] = 0.0
    identified, runs = found(robot)
    more = walk(77, 8)
    path = np.concatenate([runs[1].position_mm, more])
    truth = robot.seen(1, path, 1e-9, 3).node_mm[-8:]
    identification = Identification(Flat(), Expected(), ARC)
    foreseen = identification.foreseen_mm(identified, path)[-8:]
    drawn = identification.drawn_mm(path)[-8:]
    assert np.linalg.norm(foreseen - truth, axis=2).max() < 0.3
    assert np.linalg.norm(drawn - truth, axis=2).max() > 3.0


def test_a_blunder_in_one_pose_spoils_nothing():
    robot = Robot(3)
    _, runs = found(robot)
    runs[0].node_mm[7] += 15.0
    identified = Identification(Flat(), Expected(), ARC).identified(runs)
    np.testing.assert_allclose(identified.gain.value, robot.gain, atol=0.06)


def test_another_homing_may_leave_the_zero_elsewhere_and_sigma_says_so():
    robot = Robot(4)
    robot.bias[0], robot.bias[1] = 0.08, -0.08
    identified, _ = found(robot)
    assert (identified.bias_rad.sigma > 0.08).all()


def test_too_few_poses_are_refused():
    robot = Robot(1)
    runs = [robot.seen(0, walk(1, 9), 0.05, 1)]
    with pytest.raises(RobotPosesError, match="9 poses of the robot: at least 10 are needed"):
        Identification(Flat(), Expected(), ARC).identified(runs)
