"""What a camera sees without the robot, and the colour distance from it (equation 1)."""

import numpy as np
import pytest

from sensing.pictures.backdrop import Backdrop, noise_level
from sensing.pictures.grid import Grid
from sensing.pictures.light import luma
from sensing.scene import Scene


def test_equation_1_is_the_euclidean_distance_of_colours():
    backdrop = Backdrop.from_colour((10.0, 20.0, 30.0), (4, 3))
    picture = np.full((3, 4, 3), (10, 20, 30), np.uint8)
    picture[1, 2] = (13, 24, 42)
    picture[2, 0] = (0, 18, 41)
    distance = backdrop.distance(picture)
    assert distance.shape == (3, 4)
    part = np.s_[1:3, 0:3]
    assert np.array_equal(backdrop.distance(picture[part], part), distance[part])
    assert distance[1, 2] == pytest.approx(13.0)
    assert distance[2, 0] == pytest.approx(15.0)
    assert np.count_nonzero(distance) == 2


def test_the_bench_files_colour_is_red_green_blue(rig):
    scene = Scene.of(rig, colour_rgb=(10.0, 20.0, 30.0))
    assert {name: kept.picture[0, 0].tolist() for name, kept in scene.backdrops.items()} == {
        "left": [30, 20, 10],
        "right": [30, 20, 10],
    }
    assert scene.backdrops["left"].picture.shape == (1080, 1920, 3)


def test_a_picture_goes_before_the_colour_and_no_backdrop_is_made_of_neither(rig, encode):
    grey = encode(np.full((1080, 1920, 3), 77))
    scene = Scene.of(rig, backgrounds={"left": grey}, colour_rgb=(10.0, 20.0, 30.0))
    assert scene.backdrops["left"].picture[500, 900].tolist() == [77, 77, 77]
    assert scene.backdrops["right"].picture[500, 900].tolist() == [30, 20, 10]
    assert Scene.of(rig).backdrops == {}


def test_the_noise_of_a_background_picture_is_smoothed_away():
    rng = np.random.default_rng(1)
    noisy = np.clip(120 + rng.normal(0, 6, (300, 400, 3)), 0, 255).astype(np.uint8)
    kept = Backdrop.from_picture(noisy)
    assert kept.picture.std() < 2.5
    assert abs(float(kept.luma.mean()) - 120) < 1
    # what is left between two pictures of the same scene is the noise of the one that is looked at
    other = np.clip(120 + rng.normal(0, 6, (300, 400, 3)), 0, 255).astype(np.uint8)
    assert 2 < noise_level(kept.distance(other)) < 12


def test_a_surface_is_fitted_through_the_backdrop_and_not_through_the_robot():
    height, width = 540, 960
    y, x = np.mgrid[0:height, 0:width]
    shade = 1 - 0.25 * (x / width - 0.4) ** 2 - 0.3 * (y / height - 0.5) ** 2 - 0.1 * (x / width)
    scene = shade[..., None] * np.array([82.0, 150, 64])
    picture = scene + np.random.default_rng(2).normal(0, 2, scene.shape)
    robot = (np.abs(x - 480 - 0.0006 * (y - 300) ** 2) < 15) & (y > 120)
    picture[robot] = (70, 64, 66)
    picture[(y > 400) & (np.abs(x - 500) < 70)] = (60, 60, 60)
    fitted = Backdrop.fitted(np.clip(picture, 0, 255).astype(np.uint8)).picture.astype(float)
    error = np.abs(fitted - scene).max(axis=2)
    assert np.median(error) < 1.2
    assert error[100:440, 200:800].max() < 4
    assert error[robot].max() < 4


def test_a_nudged_camera_shows_a_neighbours_colour_and_that_is_backdrop_too():
    fold = np.full((300, 400, 3), 150, np.uint8)
    fold[:, 200:] = 90
    distance = Backdrop.from_picture(fold).distance(np.roll(fold, 1, axis=1))
    assert distance[:, 10:390].max() < 40
    fold[100:120, 50:70] = 60
    assert Backdrop.from_picture(np.full_like(fold, 150)).distance(fold)[110, 60] > 150


@pytest.mark.parametrize("gains", [(0.5, 0.5, 0.5), (1.6, 1.6, 1.6), (0.8, 1.0, 1.25)])
def test_a_backdrop_follows_the_light(to_light, to_levels, gains):
    rng = np.random.default_rng(5)
    empty = np.full((300, 400, 3), (82.0, 150, 64)) * np.linspace(0.7, 1, 400)[:, None]
    lit = to_levels(to_light(empty) * gains) + rng.normal(0, 2, empty.shape)
    lit[100:200, 150:200] = 30
    picture = np.clip(lit, 0, 255).round().astype(np.uint8)
    backdrop = Backdrop.from_picture(empty.round().astype(np.uint8))
    followed = backdrop.in_light_of(picture)
    assert followed.gains[:3] == pytest.approx(gains, rel=0.02)
    assert noise_level(followed.distance(picture)) < 0.4 * noise_level(backdrop.distance(picture))
    assert abs(float(np.median(followed.luma.astype(float) - luma(picture)))) <= 1
    assert np.abs(followed.picture.astype(float) - followed.small).mean() < 1
    again = backdrop.relit(followed.gains)
    assert np.array_equal(again.small, followed.small)
    assert np.array_equal(again.luma, followed.luma)


def test_light_that_stays_leaves_the_backdrop_as_it_is():
    empty = np.full((300, 400, 3), (82, 150, 64), np.uint8)
    noisy = empty + np.random.default_rng(6).normal(0, 3, empty.shape)
    backdrop = Backdrop.from_picture(empty)
    assert backdrop.in_light_of(noisy.round().astype(np.uint8)) is backdrop


def test_a_fitted_backdrop_is_drawn_at_both_sizes():
    picture = np.random.default_rng(7).integers(90, 110, (1080, 1920, 3), dtype=np.uint8)
    fitted = Backdrop.fitted(picture)
    assert fitted.picture.shape == (1080, 1920, 3)
    assert fitted.luma.shape == (1080, 1920)
    assert fitted.small.shape == (*Grid.of((1920, 1080)).shape, 3) == (540, 960, 3)
    assert np.abs(fitted.picture[1::2, 1::2].astype(int) - fitted.small).max() <= 1
