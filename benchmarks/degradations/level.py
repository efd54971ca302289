"""One degradation at one strength, from the robot's motion to the bytes that sensing is handed."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.degradations.coding import Coder, jpeg, noisy
from benchmarks.degradations.motions import Motion, Mover, anywhere
from benchmarks.degradations.optics import Optics, untouched
from benchmarks.degradations.rigs import Rig
from benchmarks.degradations.scenery import NOTHING_MM, REFERENCE, Bench, Sight
from benchmarks.poses import LENGTH_MM
from sensing.scene import Scene

FRAME_S = 1 / 30
EXPOSURE_S = 0.006


def at_once(_: str, time_s: float) -> float:
    """Every camera takes its picture when it should."""
    return time_s


def as_they_are(pictures: dict[str, bytes]) -> dict[str, bytes]:
    """Sensing is handed what the cameras took."""
    return pictures


def calibrated(rig: Rig) -> Rig:
    """The calibration is true."""
    return rig


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
    """What is there, what befalls the pictures on their way, and what sensing believes; defaults degrade nothing.

    `captured(camera, time_s)` says which moment the picture shows that a camera hands over for `time_s`; `handed`
    changes the coded pictures by camera; `believed` gives the calibration that sensing has for the rig that is there.
    With `background` sensing has a picture without the robot, in which the scene looks as this says.
    """

    name: str
    bench: Bench = REFERENCE
    motion: Mover = anywhere()
    captured: Callable[[str, float], float] = at_once
    exposure_s: float = EXPOSURE_S
    optics: Optics = untouched
    noise_levels: float = 2.0
    coder: Coder = jpeg()
    handed: Callable[[dict[str, bytes]], dict[str, bytes]] = as_they_are
    believed: Callable[[Rig], Rig] = calibrated
    background: Optics | None = None

    def moves(self, number: int) -> Motion:
        """The motion of a number: levels with the same kind of motion share it."""
        return self.motion(np.random.default_rng([number, 1]))

    def pictures(self, number: int, time_s: float) -> dict[str, bytes]:
        """Coded pictures by camera at a moment of the motion of a number; the same call gives the same bytes."""
        motion = self.moves(number)
        return self.handed(
            {camera.camera: self._picture(camera.camera, motion, number, time_s) for camera in self.bench.rig}
        )

    def scene(self) -> Scene:
        """What sensing believes; its method may be asked for shapes in the pictures."""
        return Scene.of(self.believed(self.bench.rig), backgrounds=self._backgrounds(), length_mm=LENGTH_MM)

    def _backgrounds(self) -> dict[str, bytes]:
        if self.background is None:
            return {}
        random = np.random.default_rng(3)
        sights = [Sight(camera, NOTHING_MM, random, self.bench) for camera in self.bench.rig]
        return {
            sight.camera.camera: jpeg()(noisy(self.background(sight.empty, sight), 2.0, random))
            for sight in sights
        }

    def _picture(self, name: str, motion: Motion, number: int, time_s: float) -> bytes:
        seen_s = self.captured(name, time_s)
        camera = next(camera for camera in self.bench.rig if camera.camera == name)
        seed = [number, zlib.crc32(name.encode())]
        noise = np.random.default_rng([*seed, round(seen_s / FRAME_S) % 1000])
        picture = self.bench.studio.picture(
            name, motion.at(seen_s - self.exposure_s / 2), motion.at(seen_s + self.exposure_s / 2)
        )
        sight = Sight(camera, motion.at(seen_s), np.random.default_rng(seed), self.bench)
        return self.coder(noisy(self.optics(picture, sight), self.noise_levels, noise))


@dataclass(frozen=True)
class Case:
    """A degradation and its levels, weakest first."""

    name: str
    levels: tuple[Level, ...]


def without(*cameras: str) -> Callable[[dict[str, bytes]], dict[str, bytes]]:
    """Sensing is handed no picture of these cameras."""
    return lambda pictures: {name: data for name, data in pictures.items() if name not in cameras}


def replaced(camera: str, change: Callable[[bytes], bytes]) -> Callable[[dict[str, bytes]], dict[str, bytes]]:
    """The bytes of one camera's picture are changed."""
    return lambda pictures: {
        name: change(data) if name == camera else data for name, data in pictures.items()
    }


def swapped(one: str, other: str) -> Callable[[dict[str, bytes]], dict[str, bytes]]:
    """Two cameras are taken for each other."""

    def _swap(pictures: dict[str, bytes]) -> dict[str, bytes]:
        return {**pictures, one: pictures[other], other: pictures[one]}

    return _swap
