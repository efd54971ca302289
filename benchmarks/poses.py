"""Poses of a robot of two 40 mm sections, and pictures of them with exact truth: what the benchmarks of sensing share.

A pose is its bends (2, 2) in rad: of each section, from the base, towards x and towards y. Both sections are circular arcs.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from messaging.frames import CameraCalibration

Array = NDArray[np.float64]

SECTION_MM = 40.0
LENGTH_MM = 2 * SECTION_MM
SECTION_ENDS_MM = np.array([SECTION_MM, LENGTH_MM])
NODES_MM = np.arange(10.0, LENGTH_MM + 1, 10.0)


def random_bends(random: np.random.Generator, largest_rad: float = 1.3) -> Array:
    """Bends (2, 2) of each section up to `largest_rad`, towards anywhere."""
    size, heading = random.uniform(0, largest_rad, 2), random.uniform(-np.pi, np.pi, 2)
    return bent(size, heading)


def bent(size_rad: Sequence[float] | Array, heading_rad: Sequence[float] | Array) -> Array:
    """Bends (2, 2) of sections that bend by `size_rad` (2,) towards `heading_rad` (2,), counted from x towards y."""
    heading = np.asarray(heading_rad)
    bends: Array = np.asarray(size_rad)[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    return bends


def centreline(bends_rad: Array) -> Array:
    """Points (81, 3) in mm, robot frame, one for each mm of arc length from base to tip."""
    lower, frame = _arc(bends_rad[0])
    upper, _ = _arc(bends_rad[1])
    return np.concatenate([lower, lower[-1] + upper[1:] @ frame.T])


def true_nodes(points_mm: Array) -> Array:
    """Nodal points (8, 3) at NODES_MM of a centreline (81, 3)."""
    nodes: Array = points_mm[NODES_MM.astype(int)]
    return nodes


def renderers(
    rig: tuple[CameraCalibration, ...], settings: SimulatedCamerasSettings | None = None
) -> Mapping[str, Renderer]:
    """A renderer for each camera, by name; each takes a second to make and 10 ms a picture."""
    chosen = settings or SimulatedCamerasSettings()
    return {camera.camera: Renderer(camera, SECTION_ENDS_MM, chosen, seed) for seed, camera in enumerate(rig)}


def photograph(cameras: Mapping[str, Renderer], points_mm: Array) -> dict[str, bytes]:
    """JPEG bytes by camera of the robot at rest along a centreline (81, 3)."""
    return {name: camera.render(points_mm, points_mm) for name, camera in cameras.items()}


def _arc(bend_rad: Array) -> tuple[Array, Array]:
    """A section's arc (41, 3) from the origin along +Z, and the frame (3, 3) at its end."""
    angle = float(np.linalg.norm(bend_rad))
    share = np.linspace(0.0, 1.0, int(SECTION_MM) + 1)
    # sinc stays exact for a straight section, where (1 - cos) / angle is 0 / 0
    aside = 0.5 * angle * share**2 * np.sinc(share * angle / (2 * np.pi)) ** 2
    along = share * np.sinc(share * angle / np.pi)
    towards = bend_rad / angle if angle else np.zeros(2)
    points = SECTION_MM * np.column_stack([aside[:, None] * towards, along])
    return points, _turn(towards, angle)


def _turn(towards: Array, angle_rad: float) -> Array:
    """The rotation (3, 3) that bends +Z towards a horizontal unit vector (2,) (Rodrigues' formula)."""
    x, y = towards
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    turn: Array = np.eye(3) + np.sin(angle_rad) * cross + (1 - np.cos(angle_rad)) * cross @ cross
    return turn
