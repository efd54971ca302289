"""The holder: a collar that the robot stands in, the block below it and the pillar below that. It moves with the stage.

Its edges are as exact as OpenCV draws them, and it is not blurred by its motion: nothing is measured on it.
"""

from itertools import pairwise

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Pixels
from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.light import Light, bgr
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.settings import BodySettings

Face = tuple[Array, Array]
"""Corners (k, 3) in the robot's directions, and the normal (3,)."""

_SHIFT = 6
_FACETS = 32
_PILLAR_MM = 200.0
_UP = np.array([0.0, 0.0, 1.0])
_REDRAWN_FROM_MM = 5e-3


class Holder:
    """The holder before one camera's backdrop."""

    def __init__(self, body: BodySettings, projection: Projection, light: Light, backdrop: Pixels) -> None:
        self._projection = projection
        self._backdrop = backdrop
        self.picture = backdrop.copy()
        """The whole picture without the robot."""
        self._drawn_for_mm = np.full(3, np.inf)
        self._camera_mm = -projection.rotation.T @ projection.to_camera(np.zeros(3))
        faces = _faces(body)
        self._corners_mm = np.concatenate([corners_mm for corners_mm, _ in faces])
        ends = np.cumsum([len(corners_mm) for corners_mm, _ in faces]).tolist()
        self._outlines = [slice(*ends_of_face) for ends_of_face in pairwise([0, *ends])]
        self._first_mm = np.array([corners_mm[0] for corners_mm, _ in faces])
        self._normals = np.array([normal for _, normal in faces])
        lit = light.brightness(self._normals @ projection.rotation.T @ light.direction)
        self._colours = (lit[:, None] * bgr(body.holder_colour)).tolist()
        self.window = Window(0, 0, 0, 0)
        """What shows of it."""

    def stand_below(self, base_mm: Array) -> None:
        """Below a base at (3,) in the robot frame."""
        if np.abs(base_mm - self._drawn_for_mm).max() > _REDRAWN_FROM_MM:
            self._redraw(base_mm)
            self._drawn_for_mm = base_mm

    def _redraw(self, base_mm: Array) -> None:
        self.picture[self.window.slices] = self._backdrop[self.window.slices]
        pixels = self._projection.to_pixels(self._projection.to_camera(self._corners_mm + base_mm))
        fixed = np.rint(pixels * (1 << _SHIFT)).astype(np.int32)
        towards_camera = self._camera_mm - base_mm - self._first_mm
        for face in np.flatnonzero((self._normals * towards_camera).sum(axis=1) > 0).tolist():
            outline = fixed[self._outlines[face]]
            cv2.fillConvexPoly(self.picture, outline, self._colours[face], cv2.LINE_AA, _SHIFT)
        limit = [self._projection.width_px, self._projection.height_px]
        corners = np.clip([pixels.min(axis=0) - 2, pixels.max(axis=0) + 3], 0, limit)
        self.window = Window(*corners.astype(int).ravel().tolist())


def _faces(body: BodySettings) -> list[Face]:
    """All faces about a base at the origin, the lower bodies first."""
    radius_mm = body.collar_diameter_mm / 2
    block_mm = -_UP * (body.collar_height_mm + body.block_mm[2] / 2)
    below_mm = block_mm - _UP * body.block_mm[2] / 2
    return [
        *_wall(below_mm, 0.75 * radius_mm, _PILLAR_MM),
        *_box(block_mm, np.array(body.block_mm) / 2),
        *_wall(0 * _UP, radius_mm, body.collar_height_mm),
        (_circle(radius_mm), _UP),
    ]


def _circle(radius_mm: float) -> Array:
    """(33, 3) closed, about the z axis."""
    angle = np.linspace(0, 2 * np.pi, _FACETS + 1)
    return radius_mm * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])


def _wall(top_mm: Array, radius_mm: float, height_mm: float) -> list[Face]:
    """The side of an upright cylinder, as facets."""
    rim = _circle(radius_mm)
    upper, lower = top_mm + rim, top_mm + rim - height_mm * _UP
    return [
        (np.array([upper[k], upper[k + 1], lower[k + 1], lower[k]]), (rim[k] + rim[k + 1]) / (2 * radius_mm))
        for k in range(_FACETS)
    ]


def _box(centre_mm: Array, half_mm: Array) -> list[Face]:
    """The faces of an upright box."""
    faces = []
    for normal in (*np.eye(3), *-np.eye(3)):
        first, second = np.roll(np.abs(normal), 1), np.roll(np.abs(normal), 2)
        around = ((-1, -1), (-1, 1), (1, 1), (1, -1))
        corners = [centre_mm + half_mm * (normal + a * first + b * second) for a, b in around]
        faces.append((np.array(corners), normal))
    return faces
