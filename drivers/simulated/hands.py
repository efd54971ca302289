"""Simulated hands that hold a board before the cameras: still at one place, then quickly to the next, for ever."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from drivers.simulated.cameras.projection import Lens

Array = NDArray[np.float64]

HELD_S = 0.7
MOVED_S = 0.25

_TILT = np.deg2rad(45.0)
_SPIN = np.deg2rad(30.0)
_STEEPEST = np.deg2rad(62.0)
_DISTANCES = 0.75, 1.2
_CELLS = 3
_MIDDLE_OF_PICTURE = 0.8
_SEEN = 0.7
_EVERY_ALONE = 5
_DRAWN = 64


class Hands:
    """Places of the board, drawn from where the cameras really are. Each camera in turn gets it in each part of its picture;
    mostly all cameras see it at once, now and then it is held for one alone. The same seed gives the same places.
    """

    def __init__(self, squares_mm: Array, lenses: Sequence[Lens], about_mm: Array, seed: int) -> None:
        """A board of size (2,), held near (3,) in the robot frame."""
        across = np.linspace(0, 1, 4)
        self._points_mm = np.array([[x, y, 0.0] for x in across for y in across]) * [*squares_mm, 1]
        self._middle_mm = np.array([*squares_mm / 2, 0.0])
        self._lenses = lenses
        self._about_mm = about_mm
        self._rng = np.random.default_rng([seed, 0x626F617264])
        self._places: list[Array] = []

    def at(self, held_s: float) -> Array:
        """`robot_from_board` (4, 4) so long after they began."""
        number, within_s = divmod(max(held_s, 0.0), HELD_S + MOVED_S)
        here = self._place(int(number))
        share = (within_s - HELD_S) / MOVED_S
        return here if share <= 0 else self._between(here, self._place(int(number) + 1), share)

    def _place(self, number: int) -> Array:
        while len(self._places) <= number:
            self._places.append(self._drawn(len(self._places)))
        return self._places[number]

    def _between(self, here: Array, there: Array, share: float) -> Array:
        share = share * share * (3 - 2 * share)
        first = Rotation.from_matrix(here[:3, :3])
        turn = (first.inv() * Rotation.from_matrix(there[:3, :3])).as_rotvec()
        between = np.eye(4)
        between[:3, :3] = (first * Rotation.from_rotvec(share * turn)).as_matrix()
        middles = [place[:3, :3] @ self._middle_mm + place[:3, 3] for place in (here, there)]
        middle_mm = (1 - share) * middles[0] + share * middles[1]
        between[:3, 3] = middle_mm - between[:3, :3] @ self._middle_mm
        return between

    def _drawn(self, number: int) -> Array:
        """The first of many draws that is seen well, or the best."""
        turn, camera = divmod(number, len(self._lenses))
        alone = number % _EVERY_ALONE == _EVERY_ALONE - 1
        looking = [self._lenses[camera]] if alone else self._lenses
        middles_mm = self._in_part(self._lenses[camera], turn % _CELLS**2)
        rotations = self._facing(np.mean([lens.centre_mm for lens in looking], axis=0) - middles_mm)
        corners_mm = middles_mm - rotations @ self._middle_mm
        points_mm = self._points_mm @ rotations.transpose(0, 2, 1) + corners_mm[:, None, :]
        seen = np.min([_seen(lens, points_mm, rotations) for lens in looking], axis=0)
        chosen = int(np.argmax(seen >= _SEEN)) if (seen >= _SEEN).any() else int(np.argmax(seen))
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = rotations[chosen], corners_mm[chosen]
        return place

    def _in_part(self, lens: Lens, cell: int) -> Array:
        """Points (n, 3) in the robot frame that this camera sees in one part of its picture."""
        row, column = divmod(cell, _CELLS)
        within = (np.array([column, row]) + self._rng.random((_DRAWN, 2))) / _CELLS
        pixels = ((within - 0.5) * _MIDDLE_OF_PICTURE + 0.5) * [lens.width_px, lens.height_px]
        away_mm = lens.to_camera(self._about_mm)[2] * self._rng.uniform(*_DISTANCES, _DRAWN)
        return lens.from_straight_ray(pixels, away_mm)

    def _facing(self, towards_mm: Array) -> Array:
        """(n, 3, 3) robot_from_board of boards that face these ways (n, 3), about upright, tilted and spun by chance."""
        into = -towards_mm / np.linalg.norm(towards_mm, axis=1, keepdims=True)
        right = np.cross(into, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right, axis=1, keepdims=True)
        upright = np.stack([right, np.cross(into, right), into], axis=-1)
        tilt, about = self._rng.uniform(0, _TILT, _DRAWN), self._rng.uniform(0, 2 * np.pi, _DRAWN)
        tilted = Rotation.from_rotvec(
            np.column_stack([tilt * np.cos(about), tilt * np.sin(about), np.zeros(_DRAWN)])
        )
        spun = Rotation.from_rotvec(self._rng.uniform(-_SPIN, _SPIN, _DRAWN)[:, None] * [0.0, 0.0, 1.0])
        facing: Array = upright @ (tilted * spun).as_matrix()
        return facing


def _seen(lens: Lens, points_mm: Array, rotations: Array) -> Array:
    """(n,) shares of boards' points (n, m, 3) in a camera's picture; 0 for boards behind it or too steep to be read."""
    in_camera = lens.to_camera(points_mm)
    pixels = lens.to_pixels(in_camera)
    inside = ((pixels >= 0) & (pixels < [lens.width_px, lens.height_px])).all(axis=-1).mean(axis=-1)
    ray = in_camera.mean(axis=1)
    facing = ((rotations[:, :, 2] @ lens.rotation.T) * ray).sum(axis=1) / np.linalg.norm(ray, axis=1)
    seen: Array = inside * (in_camera[..., 2].min(axis=1) > 0) * (facing > np.cos(_STEEPEST))
    return seen
