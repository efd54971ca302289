"""Seeded motions of the robot: ordinary ones, and those that pass through poses that cameras resolve badly."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.poses import Array, bent, centreline, random_bends
from messaging.frames import CameraCalibration

FASTEST_RAD_S = 0.9
"""Of each section: the tip then moves by some 2 mm between frames at 30 Hz."""


@dataclass(frozen=True)
class Motion:
    """Bends (2, 2) in rad at time 0, and how fast they change, in rad/s."""

    bends_rad: Array
    rate_rad_s: Array

    def at(self, time_s: float) -> Array:
        """Centreline (81, 3) in mm."""
        return centreline(self.bends_rad + time_s * self.rate_rad_s)


Mover = Callable[[np.random.Generator], Motion]


def anywhere(largest_rad: float = 1.3, fastest_rad_s: float = FASTEST_RAD_S) -> Mover:
    """Sections that bend by up to this much, towards anywhere."""

    def _motion(random: np.random.Generator) -> Motion:
        return Motion(random_bends(random, largest_rad), random_bends(random, fastest_rad_s))

    return _motion


def towards(azimuth_rad: float, first_rad: float, second_rad: float) -> Mover:
    """Both sections bend by about this much in the upright plane of an azimuth, counted from x towards y."""

    def _motion(random: np.random.Generator) -> Motion:
        size = np.array([first_rad, second_rad]) + random.uniform(-0.06, 0.06, 2)
        heading = azimuth_rad + random.uniform(-0.03, 0.03, 2)
        return Motion(bent(size, heading), random_bends(random, FASTEST_RAD_S))

    return _motion


def pointing_at(camera: CameraCalibration, off_rad: float) -> Mover:
    """The second section is straight and points above a camera by this angle."""
    eye_mm = eye(camera)
    azimuth = float(np.arctan2(eye_mm[1], eye_mm[0]))
    bends = np.linspace(0.8, 2.2, 281)
    tips = [centreline(bent((bend, 0.0), (azimuth, 0.0)))[[-2, -1]] for bend in bends]
    aim = np.array([_angle(tip - before, eye_mm - tip) for before, tip in tips])
    above = np.argmin(np.abs(aim[: np.argmin(aim) + 1] - off_rad))
    return _about(float(bends[above]), azimuth)


def along_baseline(one: CameraCalibration, other: CameraCalibration, off_rad: float) -> Mover:
    """The second section is straight and runs, up to this angle, along the line between two cameras.

    Every plane through both cameras holds that direction: the section is its own epipolar line in both pictures.
    """
    across = eye(other) - eye(one)
    azimuth = float(np.arctan2(across[1], across[0]))
    return _about(np.pi / 2 - float(np.arcsin(across[2] / np.linalg.norm(across))) - off_rad, azimuth)


def _about(bend_rad: float, azimuth_rad: float) -> Mover:
    def _motion(random: np.random.Generator) -> Motion:
        size = np.array([bend_rad, 0.0])
        drift = random_bends(random, FASTEST_RAD_S)
        jitter = random.normal(0, 0.01, (2, 2))
        return Motion(bent(size, (azimuth_rad, 0.0)) + jitter, drift)

    return _motion


def eye(camera: CameraCalibration) -> Array:
    """Where a camera stands (3,), in mm, robot frame."""
    pose = camera.camera_from_robot
    place: Array = -pose[:3, :3].T @ pose[:3, 3]
    return place


def _angle(one: Array, other: Array) -> float:
    cosine = one @ other / (np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.arccos(np.clip(cosine, -1, 1)))
