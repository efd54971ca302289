"""What speaks against a traced line: flags with a fixed vocabulary (messaging.shape.Flag), from the method's own numbers.

Ray gaps alone see no error along the epipolar plane. So the line is projected back onto every skeleton; it must walk along
both of them from base to tip without turning back, begin at the base, and be as long and as thick as a robot is.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from messaging.shape import Flag
from sensing.geometry.camera import Camera
from sensing.geometry.rays import epipolar_angles
from sensing.plain.skeleton import Skeleton
from sensing.plain.trace import BASE_RADII, Trace
from sensing.shape import Evidence

SPACING_MM = 0.5
"""The line is projected in pieces of this length."""
LARGE_RESIDUAL_PX, LARGE_RESIDUAL = 1.0, 0.1
"""A skeleton may be so far from the line: a pixel, and a share of the half width, by which disks make it step aside."""
LARGE_RAY_GAP_PX = 2.0
LARGE_BIAS_PX = 1.2
BASE_TOLERANCE_PX = 3.0
"""Gaps and offsets are in px at the base here: a skeleton is as exact as its pixels."""
LARGE_SPREAD_MM = 0.45
"""A point whose standard deviation in its worst direction is larger rests on more than the pictures."""
LONGEST_STEP = 4.0
"""From one point of the line to the next, in radii."""
SHARPEST_TURN = 1.0
"""In rad, over a piece about as long as the robot's radius: none bends about less than that."""
LEAST_ADVANCE = 0.25
"""How far a line must go on along both skeletons, in half widths, from each of its points to the next."""
LENGTH_TOLERANCE_MM = 1.5
BASE_STRETCH = 5.0
"""As far from the base, in radii, the robot is a parabola."""
THICK, THICK_SHARE = 1.45, 0.04
"""More than this share of a skeleton where the silhouette is this many times as thick as the robot: it is covering itself."""
END_REACH = 1.3
"""A skeleton ends one half width before the silhouette does: what is this near to it, in half widths, is seen."""
LEAST_SEEN = 0.9
RIM_RADII = 3.0
"""As far from the base, in the robot's radii, a skeleton may have branches into the holder's rim."""


@dataclass(frozen=True)
class Agreement:
    """How one camera's skeleton agrees with a line: its RMS distance in px from where the line appears, the length of line
    that it shows, whether it shows the end, and the share of it where the silhouette is too thick.
    """

    residual_px: float
    visible_mm: float
    shows_end: bool
    thick: float


def agreement(camera: Camera, skeleton: Skeleton, trace: Trace) -> Agreement:
    """Compare the skeleton with the line's projection, but for where the holder's rim spoils the skeleton."""
    length = float(trace.line.arc_mm[-1])
    places, _ = trace.line.at(np.linspace(0.0, length, int(length / SPACING_MM) + 2))
    pixels, scale = camera.project(places), camera.px_per_mm(places)
    apart = skeleton.pixels[:, None] - pixels[None]
    distance = np.linalg.norm(apart, axis=2)
    seen = distance.min(axis=0) < END_REACH * skeleton.half_width_px
    own = distance[:, 0] > RIM_RADII * trace.radius_mm * scale[0]
    if not own.any():
        return Agreement(float(distance.min(axis=1).max()), float(seen.mean() * length), bool(seen[-1]), 0.0)
    apart, distance, depth_px = apart[own], distance[own], skeleton.depth_px[own]
    rows, nearest = np.arange(len(apart)), distance.argmin(axis=1)
    along = np.gradient(pixels, axis=0)[nearest]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    beside = apart[rows, nearest]
    across = np.abs(along[:, 0] * beside[:, 1] - along[:, 1] * beside[:, 0])
    # beyond the line's ends there is no beside
    inner = (nearest > 0) & (nearest < len(places) - 1)
    off = np.where(inner, across, distance[rows, nearest])
    return Agreement(
        residual_px=float(np.sqrt(np.mean(off**2))),
        visible_mm=float(seen.mean() * length),
        shows_end=bool(seen[-1]),
        thick=float(np.mean(depth_px / scale[nearest] > THICK * trace.radius_mm)),
    )


def base_offset_mm(trace: Trace) -> float:
    """How far beside the base a parabola through the skeleton points above it passes that leaves it along +Z.

    Infinite where there are too few points.
    """
    height = trace.points_mm[:, 2] - trace.insertion_mm
    aside = trace.points_mm[:, :2]
    near = (np.linalg.norm(aside, axis=1) < height) & (height < BASE_STRETCH * trace.radius_mm)
    near &= height > BASE_RADII * trace.radius_mm
    if np.count_nonzero(near) < 10:
        return float("inf")
    terms = height[near, None] ** np.array([0, 2])
    return float(np.linalg.norm(np.linalg.lstsq(terms, aside[near], rcond=None)[0][0]))


def loses_its_way(trace: Trace, half_width_px: float) -> bool:
    """Whether the line goes back along a skeleton, leaps, or turns as no tube can: partners were taken from elsewhere."""
    advance_px = np.diff(trace.walk_px, axis=0).min()
    pieces = np.diff(trace.line.points_mm, axis=0)
    lengths = np.linalg.norm(pieces, axis=1)
    pieces /= np.maximum(lengths, 1e-12)[:, None]
    least_cosine = np.sum(pieces[1:] * pieces[:-1], axis=1).min()
    return bool(
        advance_px < LEAST_ADVANCE * half_width_px
        or lengths.max() > LONGEST_STEP * trace.radius_mm
        or least_cosine < np.cos(SHARPEST_TURN)
    )


def judge(
    cameras: tuple[Camera, ...],
    skeletons: Mapping[str, Skeleton],
    trace: Trace,
    length_mm: float | None,
    *,
    cut_off: bool,
) -> Evidence:
    """Judge a line; `cut_off` says that a silhouette reaches the rim of its picture or work area."""
    line = trace.line
    views = {camera.name: agreement(camera, skeletons[camera.name], trace) for camera in cameras}
    length = float(line.arc_mm[-1])
    gap, bias = float(np.abs(trace.gaps_mm).mean()), float(np.median(trace.gaps_mm))
    spread_mm = np.sqrt(np.linalg.eigvalsh(line.covariance_mm2[:-1])[:, -1])
    half_width_px = min(skeleton.half_width_px for skeleton in skeletons.values())
    px_per_mm = min(float(camera.px_per_mm(line.points_mm[:1])[0]) for camera in trace.pair)
    found = {
        Flag.LARGE_RESIDUAL: any(
            view.residual_px > LARGE_RESIDUAL_PX + LARGE_RESIDUAL * skeletons[name].half_width_px
            for name, view in views.items()
        ),
        Flag.LARGE_RAY_GAP: gap * px_per_mm > LARGE_RAY_GAP_PX,
        Flag.CALIBRATION_OFF: abs(bias) * px_per_mm > LARGE_BIAS_PX
        or base_offset_mm(trace) * px_per_mm > BASE_TOLERANCE_PX,
        Flag.EPIPOLAR_TANGENCY: loses_its_way(trace, half_width_px) or spread_mm.max() > LARGE_SPREAD_MM,
        Flag.TIP_UNSEEN: not any(view.shows_end for view in views.values()),
        Flag.LENGTH_MISMATCH: length_mm is not None and abs(length - length_mm) > LENGTH_TOLERANCE_MM,
        Flag.MERGED_SILHOUETTE: max(view.thick for view in views.values()) > THICK_SHARE,
        Flag.HIDDEN: min(view.visible_mm for view in views.values()) < LEAST_SEEN * length,
        Flag.OUT_OF_VIEW: cut_off,
    }
    return Evidence(
        residual_px={name: view.residual_px for name, view in views.items()},
        visible_mm={name: view.visible_mm for name, view in views.items()},
        ray_gap_mm=gap,
        ray_bias_mm=bias,
        epipolar_angle_rad=epipolar_angles(*trace.pair, line.points_mm, line.tangents),
        flags=tuple(flag for flag, raised in found.items() if raised),
    )
