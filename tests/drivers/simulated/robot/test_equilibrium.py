"""Forces are derivatives of energy, and tendon lengths are distances between holes."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from drivers.simulated.robot.backbone import build_backbone
from drivers.simulated.robot.equilibrium import Mechanics
from drivers.simulated.robot.settings import SimulatedRobotSettings, ideal
from drivers.simulated.robot.tendons import route_tendons
from drivers.simulated.robot.transmission import Friction, build_transmission

SETTINGS = SimulatedRobotSettings()
SIZE = 60


@pytest.fixture
def mechanics():
    """The bench robot, pushed on every disk from everywhere."""
    backbone = build_backbone(SETTINGS)
    pushes_N = np.random.default_rng(4).normal(size=backbone.disk_force_N.shape) * 0.1
    backbone = replace(backbone, disk_force_N=backbone.disk_force_N + pushes_N)
    return Mechanics(backbone, route_tendons(SETTINGS, backbone))


@pytest.fixture
def law(mechanics):
    rng = np.random.default_rng(2)
    tendons, pieces = mechanics.routing.runs.shape
    transmission = build_transmission(SETTINGS, mechanics.routing)
    straight = transmission.unengaged(mechanics.routing.runs * 4.0)
    rubbing = Friction(
        rng.random((tendons, pieces)), rng.uniform(-1, 1, (tendons, pieces)), straight.beyond_mm
    )
    return transmission.law(np.array([2.0, 1.0, -3.0, 1.0]), rubbing)


def derivative(function, at, change=1e-6):
    return np.array([(function(at + e) - function(at - e)) / (2 * change) for e in np.eye(len(at)) * change])


def test_force_is_the_derivative_of_energy(mechanics, law):
    strain = np.random.default_rng(0).normal(size=SIZE) * 0.02
    gradient = mechanics.balance(mechanics.pose(strain), law).gradient
    numeric = derivative(lambda u: mechanics.balance(mechanics.pose(u), law).energy, strain)
    np.testing.assert_allclose(gradient, numeric, atol=1e-6 * np.abs(gradient).max())


def test_hessian_is_near_enough_to_the_derivative_of_force(mechanics, law):
    strain = np.random.default_rng(1).normal(size=SIZE) * 0.01
    hessian = mechanics.hessian(mechanics.balance(mechanics.pose(strain), law))
    numeric = derivative(lambda u: mechanics.balance(mechanics.pose(u), law).gradient, strain)
    np.testing.assert_allclose(hessian, numeric, atol=0.02 * np.abs(numeric).max())


def test_forces_on_disks_resist_strain_as_their_gradient_says(mechanics):
    strain = np.random.default_rng(6).normal(size=SIZE) * 0.01
    load = mechanics.pose(strain).load
    numeric = derivative(lambda u: mechanics.pose(u).load.gradient, strain)
    exact, near = np.triu(numeric, 3), np.triu(load.second_derivative(), 3)
    np.testing.assert_allclose(near, exact, atol=0.01 * np.abs(exact).max())


def test_stiffness_of_a_round_uniform_rod():
    stiffness = build_backbone(ideal(SETTINGS)).stiffness_N_mm.reshape(-1, 3)
    second_moment_mm4 = np.pi / 4 * 0.4**4
    shear_modulus_MPa = 60e3 / (2 * 1.3)
    bending, torsion = 60e3 * second_moment_mm4, shear_modulus_MPa * 2 * second_moment_mm4
    np.testing.assert_allclose(stiffness, np.tile([4 * bending, 4 * bending, 4 * torsion], (20, 1)))


def test_tendon_distance_is_the_distance_between_holes(mechanics):
    pose = mechanics.pose(np.random.default_rng(3).normal(size=SIZE) * 0.05)
    for tendon, angle in enumerate(np.radians([0, 180, 90, 270, 45, 225, 135, 315])):
        hole = 4.0 * np.array([np.cos(angle), np.sin(angle), 0.0])
        holes = pose.points_mm + pose.frames @ hole
        distance = np.linalg.norm(np.diff(holes, axis=0), axis=1) * mechanics.routing.runs[tendon]
        np.testing.assert_allclose(pose.path.distance_mm[tendon], distance, atol=1e-6)


def test_distal_tendons_follow_the_backbone_where_coupling_is_off():
    settings = msgspec.structs.replace(SETTINGS, coupling=0.0)
    backbone = build_backbone(settings)
    mechanics = Mechanics(backbone, route_tendons(settings, backbone))
    bent = np.zeros((20, 3))
    bent[:10, 1] = 0.01
    lengths = mechanics.pose(bent.ravel()).path.distance_mm[4:].sum(axis=1)
    np.testing.assert_allclose(lengths, 80.0, atol=0.01)
