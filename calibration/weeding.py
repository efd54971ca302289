"""Corners and views that do not fit what all others agree on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.bundle import Adjusted
from calibration.rig import Observation

CORNER_SIGMAS = 6.0
MOST_LOST = 0.3
"""Share of a picture's corners that may be outliers: with more, it is the view that is wrong."""
VIEW_SIGMAS = 4.0
FLOOR_PX = 0.3
"""Neither a corner nor a view is worth a word below this; a rendered board would have its noise weeded."""


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
        astray = np.count_nonzero(~fits)
        if typical_px > max(FLOOR_PX, VIEW_SIGMAS * noise_px):
            bad[one.view] = (
                f"{names[one.camera]}: its corners are {typical_px:.2f} px off where the other views put them: the board moved "
                "between the cameras' pictures, or was bent"
            )
        elif astray > MOST_LOST * len(fits):
            bad[one.view] = (
                f"{names[one.camera]}: {astray} of {len(fits)} corners are {np.median(distance_px[~fits]):.2f} px off where the "
                "other views put them: is the board partly hidden, does it shine, or did it move?"
            )
        kept.append(one.only(fits))
    return Weeded(tuple(one for one in kept if one.view not in bad), bad)
