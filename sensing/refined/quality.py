"""What speaks against a fitted shape: flags with a fixed vocabulary (messaging.shape.Flag), from numbers of the fit."""

from collections.abc import Mapping
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from messaging.shape import Flag
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.geometry.rays import epipolar_angles, signed_gaps
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import COLLAR_MM, BaseView, Mask
from sensing.refined.measuring import Normals
from sensing.refined.refinement import Fit, Prior
from sensing.refined.surroundings import Surroundings
from sensing.refined.tube_mask import tube_mask, widened
from sensing.settings import HOLDER_RADIUS_MM
from sensing.shape import Evidence

LARGE_RESIDUAL_PX = 0.6
STRETCH = curve.SAMPLES // 15
LARGE_STRETCH_PX = 3.0
"""Mean residual over as many neighbouring normals: a stretch that disagrees drowns in the curve's RMS."""
LEAST_EXPLAINED = 0.6
"""The share of normals at which both edges must be found, in every camera."""
GAP_STRIDE = 3
LARGE_RAY_GAP_MM = 0.4
LARGE_SPREAD_MM = 0.5
"""A nodal point whose standard deviation in its worst direction is larger rests on more than the pictures."""
JUDGED_POINTS = curve.basis(np.linspace(0.1, 1.0, 10))
LENGTH_TOLERANCE_MM = 0.6
END_TOLERANCE_MM = 0.2
"""By how much the silhouette's end may lie elsewhere than the tip's outline: good fits agree to a third of this."""
OUTLINE_TOLERANCE_PX = 1.5
"""How uneven the end's outline may be: neither tip's form is like that, something hides or touches it."""
SHIFT_TOLERANCE_MM, SHIFT_TOLERANCE_PX = 0.10, 0.90
"""By how much one camera's picture may seem to lie elsewhere than its calibration says; the larger of both counts."""
LEAST_ENDS = 2
"""So many cameras must see the end: what one sees of it says nothing along its line of sight."""
SPILLED_PLACES = 3
"""So many places around the tube may show robot, out of two for each sample of the curve: dust does."""
HIDDEN_PLACES = 4
"""So many neighbouring samples of the centreline may look like backdrop."""
LEAST_SHOWN = 0.97
"""The share of the tube that must lie in every camera's picture."""
UNEXPLAINED_SHARE = 0.06
"""The share of the silhouette that may lie outside of the fitted tube: spacer disks do, a second part of the robot too."""
RIM, RIM_MM = 0.35, 0.8
"""Spacer disks stand at most so many half widths proud of the tube, and of a thin one at most so many millimetres."""


def residual_px(off: FloatArray) -> float:
    """RMS of residuals, without the worst tenth: dust and disks' rims are not the curve's. NaN without any."""
    if not off.size:
        return float("nan")
    kept = np.sort(off * off)[: max(int(0.9 * off.size), 1)]
    return float(np.sqrt(kept.sum() / kept.size))


def worst_stretch_px(normals: Normals) -> float:
    """The largest mean residual over STRETCH neighbouring normals of one camera; normals that do not count add nothing."""
    off = np.abs(normals.residual_px)
    return float(np.lib.stride_tricks.sliding_window_view(off, STRETCH, axis=1).mean(axis=2).max())


def longest_run(raised: NDArray[np.bool_]) -> int:
    """How many neighbours (n,) are raised one after another, at most."""
    down = np.flatnonzero(np.concatenate([[True], ~raised, [True]]))
    return int(np.diff(down).max()) - 1


def ray_gap_mm(cameras: tuple[Camera, ...], fit: Fit) -> float:
    """Mean gap between the rays of measured midlines at the same arc length over all pairs of cameras.

    It is NaN where no two cameras see the same stretch.
    """
    gaps = []
    for (one, first), (other, second) in combinations(enumerate(cameras), 2):
        both = np.flatnonzero(fit.normals.valid[one] & fit.normals.valid[other])[::GAP_STRIDE]
        if both.size:
            rays = [
                camera.rays(fit.normals.middle_px[index, both])
                for index, camera in ((one, first), (other, second))
            ]
            gaps.append(np.abs(signed_gaps(first, rays[0], second, rays[1])))
    return float(np.concatenate(gaps).mean()) if gaps else float("nan")


def best_epipolar_angles(cameras: tuple[Camera, ...], fit: Fit) -> FloatArray:
    """Angles (SAMPLES,) in rad to the epipolar direction of whichever two cameras see a point best."""
    pairs = [
        epipolar_angles(*pair, fit.curve.points_mm, fit.curve.velocity_mm)
        for pair in combinations(cameras, 2)
    ]
    return np.asarray(np.max(pairs, axis=0))


def judge(
    cameras: tuple[Camera, ...],
    fit: Fit,
    prior: Prior,
    around: tuple[Surroundings, ...],
    masks: Mapping[str, Mask],
) -> Evidence:
    """Judge a fit by its edges, by what the cameras see `around` it, and by the silhouettes of a cold start."""
    normals, ends = fit.normals, fit.ends
    residual = residual_px(normals.residual_px[normals.valid])
    gap = ray_gap_mm(cameras, fit)
    spread_mm = np.sqrt(np.linalg.eigvalsh(fit.covariance_mm2(JUDGED_POINTS))[:, -1])
    explained = normals.valid.mean(axis=1)
    end_mm = (ends.residual_px.mean(axis=1) * ends.mm_per_px)[ends.seen]
    off_end = bool((np.abs(end_mm) > END_TOLERANCE_MM).any())
    shift_px = np.linalg.norm(fit.shift_px, axis=1)
    shift_mm = shift_px * ends.mm_per_px
    shifted = (shift_mm > SHIFT_TOLERANCE_MM) & (shift_px > SHIFT_TOLERANCE_PX)
    contradiction = off_end and end_mm.min() < 0 < end_mm.max()
    too_long = (
        prior.length_mm is not None and abs(fit.curve.length_mm - prior.length_mm) > LENGTH_TOLERANCE_MM
    )
    merged = any(np.count_nonzero(seen.spilled) > SPILLED_PLACES for seen in around) or any(
        unexplained(camera, fit, prior.insertion_mm, masks[camera.name]) > UNEXPLAINED_SHARE
        for camera in cameras
        if camera.name in masks
    )
    hidden = any(longest_run(seen.missing) > HIDDEN_PLACES for seen in around)
    found = {
        Flag.LARGE_RESIDUAL: explained.min() < LEAST_EXPLAINED
        or not residual < LARGE_RESIDUAL_PX
        or worst_stretch_px(normals) > LARGE_STRETCH_PX,
        Flag.LARGE_RAY_GAP: not gap < LARGE_RAY_GAP_MM,
        Flag.EPIPOLAR_TANGENCY: bool((spread_mm > LARGE_SPREAD_MM).any()),
        Flag.TIP_UNSEEN: np.count_nonzero(ends.seen) < LEAST_ENDS or ends.outline_px > OUTLINE_TOLERANCE_PX,
        Flag.LENGTH_MISMATCH: too_long or (off_end and not contradiction),
        Flag.CALIBRATION_OFF: contradiction or bool(shifted.any()),
        Flag.MERGED_SILHOUETTE: merged,
        Flag.HIDDEN: hidden,
        Flag.OUT_OF_VIEW: normals.shown.mean(axis=1).min() < LEAST_SHOWN,
    }
    return Evidence(
        residual_px={
            camera.name: residual_px(off[valid])
            for camera, off, valid in zip(cameras, normals.residual_px, normals.valid, strict=True)
        },
        visible_mm={
            camera.name: float(share) * fit.curve.length_mm
            for camera, share in zip(cameras, explained, strict=True)
        },
        ray_gap_mm=gap,
        ray_bias_mm=float(shift_mm.max()),
        epipolar_angle_rad=best_epipolar_angles(cameras, fit),
        flags=tuple(flag for flag, raised in found.items() if raised),
    )


def unexplained(camera: Camera, fit: Fit, insertion_mm: float, mask: Mask) -> float:
    """The share of a silhouette (h, w) that lies outside of the fitted tube and the disks' rim around it."""
    tube, half_width = tube_mask(camera, fit.curve, Grid.of(camera.size_px))
    rim = half_width * max(RIM, RIM_MM / float(np.median(fit.curve.radius_mm)))
    outside = mask & ~widened(tube, rim)
    collar = BaseView.of(camera, insertion_mm + COLLAR_MM).below(HOLDER_RADIUS_MM, sum(mask.shape))
    cv2.fillConvexPoly(outside, np.rint(collar * 16).astype(np.int32), 0, shift=4)
    return float(np.count_nonzero(outside)) / max(int(np.count_nonzero(mask)), 1)
