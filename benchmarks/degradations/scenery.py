"""A bench's cameras, and pictures of the robot as they would be without noise and coding."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.degradations.rigs import Rig, project
from benchmarks.poses import Array, centreline, renderers
from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import (
    BodySettings,
    LightSettings,
    SensorSettings,
    SimulatedCamerasSettings,
)
from messaging.frames import CameraCalibration

Image = NDArray[np.uint8]

NOTHING_MM = 1e-2 * centreline(np.zeros((2, 2)))
"""A centreline so short that the robot is a speck on the holder."""
WITHOUT_ROBOT = BodySettings(diameter_mm=(0.01, 0.01), disk_spacing_mm=1000.0, disk_proud_mm=0.0)
FLAWLESS = SensorSettings(noise_levels=0.0, jpeg_quality=100)


@dataclass(frozen=True, eq=False)
class Bench:
    """Cameras, the robot's body and the light. One object is one bench: its renderers are made once."""

    rig: Rig = field(default_factory=default_cameras)
    body: BodySettings = BodySettings()
    light: LightSettings = LightSettings()

    @property
    def studio(self) -> "Studio":
        """Where its pictures are made."""
        return _studio(self)


REFERENCE = Bench()


class Studio:
    """Makes pictures of one bench without noise and coding."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._renderers = _renderers(bench, bench.body)
        # the speck that is left of the robot here lies where every picture is drawn anew
        self._behind = {name: _decoded(seen) for name, seen in self._renderers.items()}

    @cached_property
    def empty(self) -> Mapping[str, Image]:
        """BGR (h, w, 3) by camera, without the robot."""
        return {name: _decoded(seen) for name, seen in _renderers(self._bench, WITHOUT_ROBOT).items()}

    def picture(self, camera: str, opened_mm: Array, closed_mm: Array) -> Image:
        """BGR (h, w, 3) of the robot whose centreline (81, 3) moves from one to the other while the shutter is open."""
        robot = self._renderers[camera].draw(opened_mm, closed_mm)
        picture = self._behind[camera].copy()
        picture[robot.window.slices] = robot.pixels
        return picture


@dataclass(frozen=True, eq=False)
class Sight:
    """What one picture shows, for those who change it: the camera, the centreline (81, 3), a source of chance."""

    camera: CameraCalibration
    points_mm: Array
    random: np.random.Generator
    bench: Bench

    def pixels(self, points_mm: Array) -> Array:
        """Where points (n, 3) are seen (n, 2)."""
        return project(self.camera, points_mm)

    def px_per_mm(self, point_mm: Array) -> float:
        """The scale at a point (3,)."""
        depth_mm = self.camera.camera_from_robot[2, :3] @ point_mm + self.camera.camera_from_robot[2, 3]
        return float(self.camera.intrinsics[0, 0] / depth_mm)

    @property
    def empty(self) -> Image:
        """The same picture without the robot."""
        return self.bench.studio.empty[self.camera.camera]


@lru_cache(maxsize=2)  # a studio of two 1080p cameras is some 150 MB
def _studio(bench: Bench) -> Studio:
    return Studio(bench)


def _renderers(bench: Bench, body: BodySettings) -> Mapping[str, Renderer]:
    return renderers(bench.rig, SimulatedCamerasSettings(body=body, light=bench.light, sensor=FLAWLESS))


def _decoded(camera: Renderer) -> Image:
    jpeg = camera.render(NOTHING_MM, NOTHING_MM)
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), dtype=np.uint8)
