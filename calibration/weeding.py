"""Corners and views that do not fit what all others agree on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.bundle import Adjusted
from calibration.rig import Observation

CORNER_SIGMAS = 6.0
MOST_LOST = 0.3
"""Share of a picture's corners that may be outliers: with more, it is the view that is wrong."""
FLOOR_PX = 0.1
"""An outlier is worth a word only from here on; a rendered board would have its noise weeded."""
BAD_VIEW, BAD_VIEW_PX = 4.0, 0.3
"""A view is bad at so many times the noise, and at no less than this."""


@dataclass(frozen=True)
class Weeded:
    """The observations that stay, and by number of the view why it does not."""

    observations: tuple[Observation, ...]
    bad_views: dict[int, str]


def weed(names: Sequence[str], solved: Adjusted, observations: Sequence[Observation]) -> Weeded:
    """Drop corners that are outliers, and with all its pictures each view that has too many of them or is off as a whole."""
    kept: list[Observation] = []
    bad: dict[int, str] = {}
    for one, residual_px in zip(observations, solved.residual_px, strict=True):
        noise_px = float(solved.noise_px[one.camera])
        distance_px = np.linalg.norm(residual_px, axis=1)
        fits = distance_px < max(FLOOR_PX, CORNER_SIGMAS * noise_px)
        typical_px = float(np.median(distance_px))
        off = typical_px > max(BAD_VIEW_PX, BAD_VIEW * noise_px)
        if off or np.count_nonzero(~fits) > MOST_LOST * len(fits):
            bad[one.view] = (
                f"{names[one.camera]}: its corners are {typical_px:.2f} px off where the other views put them: the board moved "
                "between the cameras' pictures, or is bent"
            )
        kept.append(one.only(fits))
    return Weeded(tuple(one for one in kept if one.view not in bad), bad)
