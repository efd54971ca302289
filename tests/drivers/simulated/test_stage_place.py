"""The simulated screw keeps its place over a simulator that dies, for a while, and not over one that ends."""

import os
import time

import pytest

from drivers.simulated.stage_place import StagePlace


@pytest.fixture
def link(tmp_path):
    return str(tmp_path / "servos")


def test_the_next_simulator_finds_the_screw_where_it_was(link):
    assert StagePlace(link).recalled_rad() == 0.0
    place = StagePlace(link)
    place.keep(3.0)
    place.keep(7.5)
    assert StagePlace(link).recalled_rad() == 7.5


def test_small_motions_are_not_written_down(link):
    place = StagePlace(link)
    place.keep(3.0)
    place.keep(3.05)
    assert StagePlace(link).recalled_rad() == 3.0


def test_who_ends_in_good_order_leaves_nothing(link, tmp_path):
    place = StagePlace(link)
    place.keep(3.0)
    place.forget()
    place.forget()
    assert StagePlace(link).recalled_rad() == 0.0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "seven", "nan", "inf"])
def test_what_is_no_place_is_no_place(link, text, tmp_path):
    (tmp_path / "servos.stage").write_text(text)
    assert StagePlace(link).recalled_rad() == 0.0


def test_what_was_long_ago_is_forgotten(link, tmp_path):
    StagePlace(link).keep(3.0)
    long_ago = time.time() - 60
    os.utime(tmp_path / "servos.stage", (long_ago, long_ago))
    assert StagePlace(link).recalled_rad() == 0.0
