"""What the capture times of cameras' frames say. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drivers.cameras import CameraFrame

NS_PER_S = 1e9
REACH = 0.55
"""Of a period: half of it, and a little for times that tremble."""


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
    """How far apart each frame of the first camera and the frames nearest to it of every other lie, in s.

    A frame without another camera's within half a period, where that one's was lost or had not begun, does not count.
    """
    first, *others = (np.array([frame.capture_monotonic_ns for frame in those]) for those in frames.values())
    timing = timing_of(next(iter(frames.values())))
    if timing is None or not others or not all(len(those) for those in others):
        return []
    nearest = np.array([[those[np.abs(those - time).argmin()] for those in others] for time in first])
    apart_ns = np.abs(nearest - first[:, None]).max(axis=1)
    sets = np.column_stack([first, nearest])[apart_ns <= REACH * NS_PER_S / timing.rate_hz]
    return [float(span_ns / NS_PER_S) for span_ns in np.ptp(sets, axis=1)]
