"""Diffuse light: how bright a surface is."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.settings import Colour, LightSettings


@dataclass(frozen=True)
class Light:
    """One lamp far away, and light from everywhere."""

    ambient: float
    direction: Array
    """(3,) unit vector towards the lamp in the camera frame."""

    @classmethod
    def seen_by(cls, projection: Projection, settings: LightSettings) -> Self:
        """The light of the scene in a camera's frame."""
        direction = projection.rotation @ np.array(settings.direction)
        return cls(settings.ambient, direction / max(float(np.linalg.norm(direction)), 1e-9))

    def brightness(self, towards_lamp: Flat) -> Flat:
        """Brightness where a surface's normal has these components towards the lamp."""
        lit: Flat = np.float32(self.ambient) + np.float32(1 - self.ambient) * np.maximum(towards_lamp, 0)
        return lit


def bgr(colour: Colour) -> Array:
    """(3,) in the order of OpenCV."""
    return np.array(colour[::-1], dtype=np.float64)
