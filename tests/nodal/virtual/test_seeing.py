"""Shapes as a camera would give them: late, noisy, sometimes not at all."""

import msgspec
import numpy as np
import pytest

from nodal.virtual.seeing import Seeing
from nodal.virtual.settings import ShapeSettings

STRAIGHT = np.column_stack([np.zeros((41, 2)), np.linspace(0, 80, 41)])
CALM = ShapeSettings(noise_mm=0.0, jitter_s=0.0, delay_s=0.05)


def seeing(settings, seed=1):
    return Seeing(settings, 80.0, 41, 80.0, 10.0, seed)


def sightings(eyes, duration_s, line_at=lambda _: STRAIGHT):
    """Every sighting of a while, looked for every 5 ms, with the time at which it was found."""
    found = []
    for cycle in range(round(duration_s / 0.005)):
        now_s = 10.0 + 0.005 * cycle
        if sighting := eyes.arrived(now_s):
            found.append((now_s, sighting))
        eyes.look((now_s, line_at(now_s)), (now_s + 0.005, line_at(now_s + 0.005)))
    return found


def test_shapes_come_at_their_rate_and_say_their_age():
    found = sightings(seeing(CALM), 2.0)
    assert len(found) == pytest.approx(58, abs=1)
    ages = [sighting.age_s for _, sighting in found]
    assert min(ages) >= 0.05
    assert max(ages) < 0.0551


def test_a_shape_is_of_the_moment_of_its_capture():
    def moving(now_s):
        return STRAIGHT + np.array([100.0 * (now_s - 10.0), 0, 0])

    for now_s, sighting in sightings(seeing(CALM), 1.0, moving):
        expected = 100.0 * (now_s - sighting.age_s - 10.0)
        np.testing.assert_allclose(sighting.shape.node_mm[:, 0], expected, atol=1e-6)
        np.testing.assert_allclose(sighting.shape.node_mm[:, 2], [20, 40, 60, 80], atol=1e-9)


def test_noise_is_as_large_as_it_says():
    settings = msgspec.structs.replace(CALM, noise_mm=0.1)
    nodes = np.array([sighting.shape.node_mm for _, sighting in sightings(seeing(settings), 10.0)])
    assert nodes.std(axis=0).mean() == pytest.approx(0.1, rel=0.1)
    _, last = sightings(seeing(settings), 0.3)[-1]
    np.testing.assert_allclose(last.shape.centreline_mm[-1], last.shape.node_mm[-1])
    np.testing.assert_allclose(last.shape.node_covariance_mm2[0], 0.01 * np.eye(3))


def test_a_share_is_dropped_and_the_others_stay_as_they_were():
    every = sightings(seeing(ShapeSettings()), 10.0)
    some = sightings(seeing(ShapeSettings(dropped=0.2)), 10.0)
    assert len(some) / len(every) == pytest.approx(0.8, abs=0.06)
    by_number = {sighting.shape.sequence: sighting.shape for _, sighting in every}
    assert all(sighting.shape == by_number[sighting.shape.sequence] for _, sighting in some)


def test_the_newest_arrival_counts_where_two_came_at_once():
    eyes = seeing(CALM)
    eyes.look((10.0, STRAIGHT), (10.2, STRAIGHT))
    sighting = eyes.arrived(10.4)
    assert sighting.shape.sequence == 6
    assert eyes.arrived(10.5) is None


def test_what_is_lost_flagged_or_refused():
    eyes = seeing(CALM)
    eyes.flags = ("out_of_view",)
    assert not sightings(eyes, 0.3)[-1][1].shape.trusted
    eyes = seeing(CALM)
    eyes.refusal = "no robot in sight"
    shape = sightings(eyes, 0.3)[-1][1].shape
    assert (shape.refusal, len(shape.node_names), shape.node_mm.shape) == ("no robot in sight", 0, (0, 3))
    eyes = seeing(CALM)
    eyes.lost = True
    assert sightings(eyes, 0.3) == []
