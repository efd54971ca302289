"""How a scene is lit, and how the backdrop and what stands before it differ. Pure.

The backdrop is the smooth surface that sensing fits to a picture (`Backdrop.fitted`), and what differs from it by more than sensing's
lowest threshold stands out: the robot, its holder, whatever else there is.
"""

from dataclasses import dataclass

import cv2
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
BESIDE_PX = 4
"""Detection pixels; a tube is wider, and its own shading begins farther inside."""


@dataclass(frozen=True, eq=False)
class Lighting:
    """`level` is the backdrop's median brightness, `clipped_share` the part of the picture in which a colour is clipped.

    `contrast` is the typical colour distance from the backdrop of what stands out, beside its edges, so that soft shadows do not
    count; `backdrop_noise` is that of the backdrop from its smooth surface, both in levels; `falloff` is the darkest place's light over the brightest's, in linear light.
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


def lighting_of(picture: Image, edges: NDArray[np.intp]) -> Lighting:
    """Of a BGR picture (h, w, 3) with strong edges at places (n, 2), x and y in px."""
    grid = Grid.of((picture.shape[1], picture.shape[0]))
    small = grid.reduced(picture)
    backdrop = Backdrop.fitted(small, grid)
    distance = backdrop.distance(small)
    noise = noise_level(distance)
    standing_out = distance > max(LEAST_DISTANCE, NOISE_FACTOR * noise)
    beside_edges = standing_out & _beside(edges // grid.step, standing_out.shape)
    things = beside_edges if beside_edges.any() else standing_out
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
        contrast=float(np.median(distance[things])) if things.any() else 0.0,
        backdrop_noise=noise,
        falloff=float(darkest / max(brightest, 1e-6)),
        standing_out_share=float(standing_out.mean()),
        clipped=clipped,
        standing_out=standing_out,
        places=np.asarray(light[np.ix_(*centres)] / max(brightest, 1e-6)),
    )


def _beside(places: NDArray[np.intp], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels (h, w) no farther than BESIDE_PX from these places (n, 2)."""
    near = np.zeros(shape, np.uint8)
    near[np.minimum(places[:, 1], shape[0] - 1), np.minimum(places[:, 0], shape[1] - 1)] = 1
    return np.asarray(cv2.dilate(near, np.ones((2 * BESIDE_PX + 1,) * 2, np.uint8)), dtype=bool)
