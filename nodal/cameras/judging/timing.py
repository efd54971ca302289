"""What the capture times of cameras' frames say. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drivers.cameras import CameraFrame, worst_skew_periods

NS_PER_S = 1e9
TREMBLING = 0.05
"""By so much of a period times may be off."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """`rate_hz` by which frames came, `lost` of how many that were taken."""

    rate_hz: float
    lost: int
    taken: int


def timing_of(frames: Sequence[CameraFrame]) -> Timing | None:
    """Of one camera's frames in their order; None of fewer than two."""
    if len(frames) < 2:
        return None
    taken = frames[-1].number - frames[0].number + 1
    span_s = (frames[-1].capture_monotonic_ns - frames[0].capture_monotonic_ns) / NS_PER_S
    return Timing(rate_hz=(taken - 1) / span_s, lost=taken - len(frames), taken=taken) if span_s > 0 else None


def skews_s(frames: Mapping[str, Sequence[CameraFrame]]) -> list[float]:
    """How far apart the frames lie, in s, of the closest set that each frame of the first camera can be in.

    A frame counts not that is in none as close as cameras come at worst: another camera's was lost, or had not begun.
    """
    times_ns = [np.array([frame.capture_monotonic_ns for frame in those]) for those in frames.values()]
    timing = timing_of(next(iter(frames.values())))
    if timing is None or len(times_ns) < 2:
        return []
    closest_ns: dict[int, int] = {}
    for begin_ns in np.concatenate(times_ns):
        following = [those[those >= begin_ns] for those in times_ns]
        if all(map(len, following)):
            first_ns, span_ns = int(following[0][0]), int(max(those[0] for those in following) - begin_ns)
            closest_ns[first_ns] = min(span_ns, closest_ns.get(first_ns, span_ns))
    allowed_ns = (worst_skew_periods(len(times_ns)) + TREMBLING) * NS_PER_S / timing.rate_hz
    return [span_ns / NS_PER_S for span_ns in closest_ns.values() if span_ns <= allowed_ns]
