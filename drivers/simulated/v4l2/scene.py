"""What stands before a stand-in camera: sharp where it is focused on, bright as it exposes, noisy as it amplifies."""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping

import cv2
import numpy as np
from linuxpy.video.raw import ControlID
from numpy.typing import NDArray

GAMMA = 2.2
GAIN_STEPS = 64
"""So much gain doubles light and noise."""
PICTURES = 3


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """`picture` (h, w, 3) is BGR as it looks sharp and exposed for `exposed_at` without gain, all in the controls' own numbers;
    off `sharp_at`, each step of focus blurs by `blur_px` (standard deviation).
    """

    picture: NDArray[np.uint8]
    sharp_at: int = 60
    blur_px: float = 0.05
    exposed_at: int = 100
    noise_levels: float = 1.0

    def seen(self, controls: Mapping[int, int]) -> Iterator[bytes]:
        """Picture after picture, coded, with the `controls` that there are as they are at that moment."""
        held: tuple[int, ...] = ()
        pictures: Iterator[bytes] = iter(())
        while True:
            now = (
                controls.get(ControlID.FOCUS_ABSOLUTE, self.sharp_at),
                controls.get(ControlID.EXPOSURE_ABSOLUTE, self.exposed_at),
                controls.get(ControlID.GAIN, 0),
            )
            if now != held:
                held, pictures = now, itertools.cycle(self._taken(*now))
            yield next(pictures)

    def _taken(self, focus: int, exposure: int, gain: int) -> list[bytes]:
        """A few that differ by their noise."""
        amplified = 2 ** (gain / GAIN_STEPS)
        light = (self.picture / 255) ** GAMMA * (amplified * exposure / self.exposed_at)
        if focus != self.sharp_at:
            light = np.asarray(cv2.GaussianBlur(light, (0, 0), self.blur_px * abs(focus - self.sharp_at)))
        levels = 255 * np.clip(light, 0, 1) ** (1 / GAMMA)
        random = np.random.default_rng(0)
        noises = (random.normal(0, self.noise_levels * amplified, levels.shape) for _ in range(PICTURES))
        return [
            cv2.imencode(
                ".jpg", np.clip(levels + noise, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 95]
            )[1].tobytes()
            for noise in noises
        ]
