"""What the capture times of cameras' frames say. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drivers.cameras import CameraFrame

NS_PER_S = 1e9


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

    Frames from before or after all those of another camera do not count.
    """
    first, *others = (np.array([frame.capture_monotonic_ns for frame in those]) for those in frames.values())
    if not others or not all(len(those) for those in others):
        return []
    begins, ends = max(those[0] for those in others), min(those[-1] for those in others)
    period_ns = np.median(np.diff(first)) if len(first) > 1 else 0.0
    within = first[(first >= begins - period_ns / 2) & (first <= ends + period_ns / 2)]
    return [
        _spread_ns([those[np.abs(those - time).argmin()] for those in others], time) / NS_PER_S
        for time in within
    ]


def _spread_ns(times_ns: Sequence[int], time_ns: int) -> float:
    return float(max(*times_ns, time_ns) - min(*times_ns, time_ns))
