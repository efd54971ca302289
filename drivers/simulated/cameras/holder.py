"""The holder: a collar that the robot stands in, the block below it and the pillar below that. It moves with the stage.

Its edges are as exact as OpenCV draws them, and it is not blurred by its motion: nothing is measured on it.
"""

from collections.abc import Iterator

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Pixels, Plane
from drivers.simulated.cameras.light import Light, bgr
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.settings import BodySettings

Face = tuple[Array, Array]
"""Corners (k, 3) in the robot frame, and the normal (3,)."""

_SHIFT = 6
_FACETS = 48
_PILLAR_MM = 200.0
_UP = np.array([0.0, 0.0, 1.0])
_REDRAWN_FROM_MM = 1e-3


class Holder:
    """The holder before one camera's backdrop."""

    def __init__(self, body: BodySettings, projection: Projection, light: Light, backdrop: Pixels) -> None:
        self._body = body
        self._projection = projection
        self._light = light
        self._colour = bgr(body.holder_colour)
        self._backdrop = backdrop
        self._picture = backdrop.copy()
        self._planes = [np.ascontiguousarray(plane) for plane in np.moveaxis(backdrop, 2, 0)]
        self._drawn_for_mm = np.full(3, np.inf)
        self._camera_mm = -projection.rotation.T @ projection.to_camera(np.zeros(3))
        self.corners_px = np.zeros((2, 2))
        """The first and the last column and row of what is seen of it."""

    def planes(self, base_mm: Array) -> list[Plane]:
        """Blue, green and red of the backdrop with the holder below a base at (3,) in the robot frame."""
        if np.abs(base_mm - self._drawn_for_mm).max() > _REDRAWN_FROM_MM:
            self._redraw(base_mm)
            self._drawn_for_mm = base_mm
        return self._planes

    def _redraw(self, base_mm: Array) -> None:
        before = self._box()
        self._picture[before] = self._backdrop[before]
        faces = list(self._faces(base_mm))
        corners = np.concatenate([corners_mm for corners_mm, _ in faces])
        pixels = self._projection.to_pixels(self._projection.to_camera(corners))
        normals = np.array([normal for _, normal in faces])
        lit = self._light.brightness(normals @ self._projection.rotation.T @ self._light.direction)
        colours = (lit[:, None] * self._colour).tolist()
        fixed = np.rint(pixels * (1 << _SHIFT)).astype(np.int32)
        ends = np.cumsum([len(corners_mm) for corners_mm, _ in faces])
        for outline, colour in zip(np.split(fixed, ends[:-1]), colours, strict=True):
            cv2.fillConvexPoly(self._picture, outline, colour, cv2.LINE_AA, _SHIFT)
        limit = [self._projection.width_px, self._projection.height_px]
        self.corners_px = np.clip([pixels.min(axis=0) - 2, pixels.max(axis=0) + 2], 0, limit)
        for changed in (before, self._box()):
            for channel, plane in enumerate(self._planes):
                plane[changed] = self._picture[(*changed, channel)]

    def _box(self) -> tuple[slice, slice]:
        (left, top), (right, bottom) = self.corners_px.astype(int)
        return slice(top, bottom), slice(left, right)

    def _faces(self, base_mm: Array) -> Iterator[Face]:
        """What faces the camera, the lower things first."""
        radius_mm = self._body.collar_diameter_mm / 2
        block_mm = base_mm - _UP * (self._body.collar_height_mm + self._body.block_mm[2] / 2)
        below_mm = block_mm - _UP * self._body.block_mm[2] / 2
        yield from self._facing(_wall(below_mm, 0.75 * radius_mm, _PILLAR_MM))
        yield from self._facing(_box(block_mm, np.array(self._body.block_mm) / 2))
        yield from self._facing(_wall(base_mm, radius_mm, self._body.collar_height_mm))
        yield from self._facing([(base_mm + _circle(radius_mm), _UP)])

    def _facing(self, faces: list[Face]) -> Iterator[Face]:
        return (face for face in faces if face[1] @ (self._camera_mm - face[0][0]) > 0)


def _circle(radius_mm: float) -> Array:
    """(49, 3) closed, about the z axis."""
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
