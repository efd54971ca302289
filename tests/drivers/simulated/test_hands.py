"""Simulated hands: where they hold the board, and how they get there."""

import dataclasses

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.projection import Lens
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.hands import HELD_S, MOVED_S, Hands

SQUARES_MM = np.array([90.0, 70.0])
ABOUT_MM = np.array([0.0, 0.0, 40.0])
PERIOD_S = HELD_S + MOVED_S
GRID_MM = np.array([[x, y, 0.0] for x in np.linspace(0, 90, 10) for y in np.linspace(0, 70, 8)])


def hands(seed=1, cameras=None):
    return Hands(SQUARES_MM, [Lens(camera) for camera in cameras or default_cameras()], ABOUT_MM, seed)


def projected(camera, place):
    camera_from_board = camera.camera_from_robot @ place
    turn, _ = cv2.Rodrigues(camera_from_board[:3, :3])
    return cv2.projectPoints(GRID_MM, turn, camera_from_board[:3, 3], camera.intrinsics, camera.distortion)[
        0
    ][:, 0]


def test_a_place_is_held_exactly_and_left_within_a_quarter_second():
    held = hands()
    for number in range(5):
        begin, end = number * PERIOD_S, number * PERIOD_S + HELD_S
        np.testing.assert_array_equal(held.at(begin + 1e-6), held.at(end - 1e-6))
        on_the_way = np.array([held.at(end + share * MOVED_S) for share in np.linspace(0.02, 0.98, 50)])
        steps_mm = np.linalg.norm(np.diff(on_the_way[:, :3, 3], axis=0), axis=1)
        assert (steps_mm > 0).all()
        assert steps_mm.max() < 15
        np.testing.assert_allclose(held.at(end + MOVED_S - 1e-6), held.at(end + MOVED_S + 1e-6), atol=1e-3)
    for place in (held.at(0.3), held.at(HELD_S + 0.1)):
        np.testing.assert_allclose(place[:3, :3] @ place[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(place[:3, :3]) == pytest.approx(1)


def test_the_places_cover_both_pictures_at_many_tilts_and_are_mostly_seen_by_both():
    held = hands()
    places = [held.at(number * PERIOD_S) for number in range(40)]
    both = 0
    seen_at = {camera.camera: [] for camera in default_cameras()}
    for place in places:
        shares = []
        for camera in default_cameras():
            pixels = projected(camera, place)
            inside = ((pixels >= 0) & (pixels < [camera.width_px, camera.height_px])).all(axis=1)
            shares.append(inside.mean())
            seen_at[camera.camera] += pixels[inside].tolist()
        both += min(shares) > 0.5
        assert max(shares) > 0.5
    into = np.array([place[:3, 2] for place in places])
    ahead = into.mean(axis=0) / np.linalg.norm(into.mean(axis=0))
    tilts = np.degrees(np.arccos(into @ ahead))
    assert 35 <= both < 40
    for pixels in seen_at.values():
        filled, _, _ = np.histogram2d(*np.array(pixels).T, bins=(8, 5), range=((0, 1920), (0, 1080)))
        assert (filled > 0).mean() > 0.9
    assert 19 < np.median(tilts) < 30
    assert 55 < tilts.max() < 75


def test_the_same_seed_gives_the_same_places_whenever_they_are_asked_for():
    first, second, other = hands(), hands(), hands(seed=2)
    late = first.at(7 * PERIOD_S)
    for number in range(7):
        np.testing.assert_array_equal(first.at(number * PERIOD_S), second.at(number * PERIOD_S))
    np.testing.assert_array_equal(late, second.at(7 * PERIOD_S))
    assert not np.allclose(late, other.at(7 * PERIOD_S))


def test_a_board_can_be_held_before_three_cameras_far_apart():
    left, right = default_cameras()
    behind = dataclasses.replace(
        left, camera="behind", camera_from_robot=left.camera_from_robot @ np.diag([-1.0, -1.0, 1.0, 1.0])
    )
    held = hands(cameras=(left, right, behind))
    assert all(np.isfinite(held.at(number * PERIOD_S)).all() for number in range(12))
