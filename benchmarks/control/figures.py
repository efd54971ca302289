"""What one run says: how near, how calm, and what went wrong."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.paths import TIP
from controller.limits import Limits
from nodal.virtual.samples import Samples

Array = NDArray[np.float64]

LOST_MM = 20.0
"""An error beyond this is no tracking any more."""
SWAYING_MM = 0.5
"""A sway of the tip about its own slow motion that is no tracking any more, when it has not died down at the end."""
_SLOW_S = 0.5
_ROUNDING = 1e-6


@dataclasses.dataclass(frozen=True, kw_only=True)
class Figures:
    """Of one run. What a scenario does not measure is nan."""

    rms_mm: float
    worst_mm: float
    settle_s: float = np.nan
    overshoot_percent: float = np.nan
    held: float
    """Share of the time in which nobody led the tip."""
    violations: int
    """Cycles whose command left travel or rate."""
    slack: float
    """Share of the time in which a tendon was slack."""
    tension_N: float = 0.0
    """The highest."""
    unstable: bool
    fault: str


def tracked(samples: Samples, limits: Limits) -> Figures:
    """Of a run along a path, or at rest."""
    error = samples.error_mm(TIP)
    seen = error[np.isfinite(error)]
    return Figures(
        rms_mm=float(np.sqrt((seen**2).mean())) if len(seen) else np.nan,
        worst_mm=float(seen.max()) if len(seen) else np.nan,
        held=1.0 - len(seen) / len(error),
        violations=violations(samples, limits),
        slack=float((samples.tension_N <= 0).any(axis=1).mean()),
        tension_N=float(samples.tension_N.max()),
        unstable=bool((seen > LOST_MM).any()) or sways(samples),
        fault=next((r for m, r in zip(samples.mode, samples.reason, strict=True) if m == "fault"), ""),
    )


def violations(samples: Samples, limits: Limits) -> int:
    """Cycles in which what was sent left the travel, or moved on faster than allowed."""
    command = samples.command_mm.reshape(-1, samples.command_mm.shape[-1])
    beyond = (command < limits.low_mm - _ROUNDING) | (command > limits.high_mm + _ROUNDING)
    period_s = float(np.median(np.diff(samples.now_s))) / samples.command_mm.shape[1]
    rate = np.abs(np.diff(command, axis=0)) > limits.rate_mm_s * period_s * (1 + _ROUNDING) + 1e-9
    return int(beyond.any(axis=1).sum() + rate.any(axis=1).sum())


def sways(samples: Samples) -> bool:
    """Whether the tip sways about its own slow motion at the end, more than a robot that is led does."""
    period_s = float(np.median(np.diff(samples.now_s)))
    width = 2 * round(_SLOW_S / period_s / 2) + 1
    tip = samples.node_mm[-6 * width :, samples.node_names.index(TIP)]
    if len(tip) < 2 * width:
        return False
    window = np.ones(width) / width
    slow = np.column_stack([np.convolve(axis, window, mode="valid") for axis in tip.T])
    fast = np.linalg.norm(tip[width // 2 : width // 2 + len(slow)] - slow, axis=1)
    return bool(np.sqrt((fast**2).mean()) > SWAYING_MM)


def stepped(samples: Samples, start_mm: Array, goal_mm: Array, within_mm: float = 0.5) -> tuple[float, float]:
    """Of a step that begins with the samples: when the tip stays within `within_mm` of its goal (s), and overshoot (%)."""
    tip = samples.node_mm[:, samples.node_names.index(TIP)]
    far = np.flatnonzero(np.linalg.norm(tip - goal_mm, axis=1) > within_mm)
    way = goal_mm - start_mm
    beyond = (tip - goal_mm) @ way / (way @ way)
    settled = samples.now_s[far[-1]] - samples.now_s[0] if len(far) < len(tip) else np.inf
    return (np.inf if far[-1] == len(tip) - 1 else float(settled)), 100 * max(float(beyond.max()), 0.0)
