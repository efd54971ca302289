"""Sets of pictures taken from a moment on, of something that stands still."""

import time
from collections.abc import Callable, Mapping, Sequence

from drivers.cameras import Camera
from drivers.cameras.frame_sets import frame_sets
from nodal.errors import CalibrationError

SILENCE_S = 3.0
WITHIN_S = 10.0

Jpegs = Mapping[str, bytes]
"""Coded pictures by camera."""


def taken(
    cameras: Sequence[Camera],
    maximum_skew_s: float,
    count: int,
    since_ns: int = 0,
    meanwhile: Callable[[], object] = lambda: None,
) -> list[Jpegs]:
    """At most `count` whole sets that were captured after `since_ns` (monotonic): fewer only of cameras that end.

    `meanwhile` is called on every turn of the wait. Raises CameraSilentError, and CalibrationError when the cameras give
    frames but no sets, or none of some camera's pictures.
    """
    sets: list[Jpegs] = []
    end_s = time.monotonic() + WITHIN_S
    for found in frame_sets(cameras, maximum_skew_s, SILENCE_S):
        if found is None:
            meanwhile()
        elif found.capture_monotonic_ns >= since_ns and len(found.frames) == len(cameras):
            sets.append({frame.name: frame.jpeg for frame in found.frames})
            end_s = time.monotonic() + WITHIN_S
        if len(sets) == count:
            break
        if time.monotonic() > end_s:
            raise CalibrationError(
                f"{', '.join(camera.name for camera in cameras)}: no set of pictures taken within "
                f"{maximum_skew_s:g} s of one another came for {WITHIN_S:g} s"
            )
    if not sets:
        names = ", ".join(camera.name for camera in cameras)
        raise CalibrationError(f"{names}: there is not one picture of each camera that were taken together")
    return sets
