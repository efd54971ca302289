"""How a scene is lit, and how the backdrop and what stands before it differ. Pure.

The backdrop is the smooth surface that sensing fits to a picture (`Backdrop.fitted`), and what differs from it by more than sensing's
lowest threshold stands out: the robot, its holder, whatever else there is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.backdrop import Backdrop, noise_level
from sensing.pictures.grid import Grid
from sensing.pictures.light import BRIGHTEST, LINEAR, Image, luma
from sensing.pictures.segmentation import LEAST_DISTANCE, NOISE_FACTOR

EXTREMES = 1, 99
"""Percentiles that stand for the brightest and the darkest place."""
PLACES = 5, 3


@dataclass(frozen=True, eq=False)
class Lighting:
    """`level` is the backdrop's median brightness, `clipped_share` the part of the picture in which a colour is clipped.

    `contrast` is the typical colour distance of what stands out from the backdrop, `backdrop_noise` that of the backdrop from
    its smooth surface, in levels; `falloff` is the darkest place's light over the brightest's, in linear light.
    """

    level: float
    clipped_share: float
    contrast: float
    backdrop_noise: float
    falloff: float
    standing_out_share: float
    clipped: NDArray[np.bool_]
    """Pixels (h, w) at full size."""
    standing_out: NDArray[np.bool_]
    """Detection pixels (h, w)."""
    places: FloatArray
    """The backdrop's light (3, 5) over the picture, as a share of the brightest place's."""


def lighting_of(picture: Image) -> Lighting:
    """Of a BGR picture (h, w, 3)."""
    grid = Grid.of((picture.shape[1], picture.shape[0]))
    small = grid.reduced(picture)
    backdrop = Backdrop.fitted(small, grid)
    distance = backdrop.distance(small)
    noise = noise_level(distance)
    standing_out = distance > max(LEAST_DISTANCE, NOISE_FACTOR * noise)
    clipped = picture.max(axis=2) > BRIGHTEST
    light = LINEAR[backdrop.luma]
    darkest, brightest = np.percentile(light[::8, ::8], EXTREMES)
    centres = [
        ((np.arange(count) + 0.5) * size / count).astype(int)
        for count, size in zip(PLACES[::-1], light.shape, strict=True)
    ]
    return Lighting(
        level=float(np.median(luma(small)[~standing_out])),
        clipped_share=float(clipped.mean()),
        contrast=float(np.median(distance[standing_out])) if standing_out.any() else 0.0,
        backdrop_noise=noise,
        falloff=float(darkest / max(brightest, 1e-6)),
        standing_out_share=float(standing_out.mean()),
        clipped=clipped,
        standing_out=standing_out,
        places=np.asarray(light[np.ix_(*centres)] / max(brightest, 1e-6)),
    )
