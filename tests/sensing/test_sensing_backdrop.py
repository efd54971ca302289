"""What a camera sees without the robot, and the colour distance from it (equation 1)."""

import numpy as np
import pytest

from sensing.pictures.backdrop import Backdrop, luma, noise_level, reduced
from sensing.scene import Scene


def test_equation_1_is_the_euclidean_distance_of_colours():
    backdrop = Backdrop.from_colour((10.0, 20.0, 30.0), (8, 6))
    picture = np.full((6, 8, 3), (10, 20, 30), np.uint8)
    picture[2:4, 4:6] = (13, 24, 42)
    picture[4:6, 0:2] = (0, 18, 41)
    distance = backdrop.distance(reduced(picture))
    assert distance.shape == (3, 4)
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


def test_detection_pixels_are_means_of_four():
    picture = np.zeros((2, 4, 3), np.uint8)
    picture[:, 2:] = [[[10, 0, 0], [20, 0, 0]], [[30, 0, 0], [40, 0, 0]]]
    assert reduced(picture).tolist() == [[[0, 0, 0], [25, 0, 0]]]


def test_brightness_of_a_grey_picture_is_the_picture():
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4)
    assert luma(grey) is grey
    assert luma(np.full((1, 1, 3), (0, 255, 0), np.uint8))[0, 0] == 150


def test_the_noise_of_a_background_picture_is_smoothed_away():
    rng = np.random.default_rng(1)
    noisy = np.clip(120 + rng.normal(0, 6, (300, 400, 3)), 0, 255).astype(np.uint8)
    kept = Backdrop.from_picture(noisy)
    assert kept.picture.std() < 2.5
    assert abs(float(kept.luma.mean()) - 120) < 1
    # what is left between two pictures of the same scene is the noise of the one that is looked at
    other = np.clip(120 + rng.normal(0, 6, (300, 400, 3)), 0, 255).astype(np.uint8)
    assert 2 < noise_level(kept.distance(reduced(other))) < 12


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
