"""Ways through cluttered scenes: every configuration keeps its distance, ends are exact, and neighbours are close."""

import numpy as np
import pytest

from controller.planning.search import Search
from controller.planning.space import Space
from controller.regions import Sphere

SPARE_MM = 0.5


def cluttered(stand_ins, random, balls=8):
    places = random.uniform([-50, -50, 20], [50, 50, 110], (balls, 3))
    settings = stand_ins["settings"](
        forbidden=tuple(
            Sphere(name=f"ball {n}", centre_mm=tuple(place), radius_mm=8.0)
            for n, place in enumerate(places.tolist())
            if np.hypot(*place[:2]) > 16
        )
    )
    return Space(stand_ins["plant"](settings))


def free(space, random):
    tried = np.array([space.random(random) for _ in range(50)])
    return tried[space.spare_mm(tried) > SPARE_MM + 0.5][:2]


@pytest.mark.parametrize("seed", range(12))
def test_a_way_keeps_its_distance_everywhere_and_ends_where_it_should(stand_ins, seed):
    random = np.random.default_rng(seed)
    space = cluttered(stand_ins, random)
    begin, goal = free(space, random)
    way = Search(space, SPARE_MM, seed).way(begin, goal[None], 3000).configurations
    np.testing.assert_array_equal(way[[0, -1]], [begin, goal])
    assert (space.spare_mm(way) >= SPARE_MM).all()
    # in between the body moves by a few mm at most, so it cannot have come nearer by much
    assert space.sweep_mm(np.diff(way, axis=0)).max() < 6.0
    assert (space.spare_mm((way[1:] + way[:-1]) / 2) >= SPARE_MM - 0.3).all()
    np.testing.assert_allclose(space.within(way), way, atol=1e-9)


def test_a_straight_way_to_any_of_the_goals_is_preferred(stand_ins):
    space = Space(stand_ins["plant"](stand_ins["settings"](forbidden=(stand_ins["LAMP"],))))
    begin = space.straight(0.0)
    through, beside = np.array([[3.0, 0, 5.0, 0, 0], [0, 0, 0, 4.0, 0]])
    assert Search(space, 0.0, 0).way(begin, through[None], 0) is None, "the lamp is on this way"
    way = Search(space, 0.0, 0).way(begin, np.stack([through, beside]), 0)
    assert way.samples == 0
    np.testing.assert_allclose(way.configurations[-1], beside)
