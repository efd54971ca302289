"""Robots of every kind, and regions in their way."""

import numpy as np
import pytest

from controller.planning.space import Space
from controller.plant import Plant
from controller.regions import HalfSpace, Sphere
from controller.settings import ControllerSettings, SectionTendons
from messaging.settings import RobotSettings

LAMP = Sphere(name="lamp", centre_mm=(22.0, 0.0, 62.0), radius_mm=6.0)
WALL = HalfSpace(name="wall", point_mm=(-45.0, 0.0, 0.0), normal=(2.0, 0.0, 0.0))
PAIRS = (0.0, 90.0)
SINGLE = (0.0, 120.0, 240.0)


def settings_of(sections=2, *, single=False, forbidden=(), **others):
    section = SectionTendons(tendon_angle_deg=SINGLE) if single else SectionTendons(pair_angle_deg=PAIRS)
    return ControllerSettings(sections=(section,) * sections, forbidden=forbidden, **others)


def plant_of(settings, *, stage=True):
    sections = len(settings.sections)
    return Plant.of(settings, RobotSettings(section_length_mm=(80.0 / sections,) * sections, stage=stage))


ROBOTS = [(n, single, stage) for n in (1, 2, 3, 4) for single in (False, True) for stage in (False, True)]


@pytest.fixture(params=ROBOTS, ids=lambda robot: f"{robot[0]} sections, single {robot[1]}, stage {robot[2]}")
def any_space(request):
    """One to four sections, with pairs or three single tendons each, with and without a stage."""
    sections, single, stage = request.param
    return Space(plant_of(settings_of(sections, single=single), stage=stage))


@pytest.fixture
def stand_ins():
    """What tests build plants from."""
    return {"settings": settings_of, "plant": plant_of, "LAMP": LAMP, "WALL": WALL}


@pytest.fixture
def random():
    return np.random.default_rng(5)
