"""The robot's shape from nothing but pictures: METHOD steps 2 to 8, as the start of the refinement.

Each stage's result stays available, so that a picture of every step can be drawn.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.geometry.rays import best_pair, ray_gaps, triangulate
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.grid import Grid
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import BaseView, Limits, Mask, robot_mask
from sensing.refined.midline import half_width, midlines
from sensing.refined.tube import Curve
from sensing.refined.tube_mask import tube_mask
from sensing.refined.walk import ordered_pairs
from sensing.scene import Scene
from sensing.shape import Silhouette, Stages

MIDLINE_POINTS = 100
LEAST_LENGTH_MM = 5.0
BASE_STRETCH = 0.05
"""The share of the walk next to the base that is left to the base's known pose: the holder's rim blurs it."""


@dataclass(frozen=True)
class ColdStart:
    """The first curve, and the stages that led to it."""

    curve: Curve
    stages: Stages


def cold_start(
    scene: Scene, pictures: Mapping[str, Picture], backdrops: Mapping[str, Backdrop], insertion_mm: float
) -> ColdStart:
    """Find the robot in every picture and in space; raises RefusedError naming the camera that does not show it."""
    found = {
        camera.name: _silhouettes(
            camera, pictures[camera.name], backdrops[camera.name], insertion_mm, scene.limits(camera.name)
        )
        for camera in scene.cameras
    }
    base_mm = np.array([0.0, 0.0, insertion_mm])
    pair = best_pair(scene.cameras, base_mm)
    matches = [matched(pair, chosen, base_mm) for chosen in product(*(found[camera.name] for camera in pair))]

    masks = {name: choices[0].mask for name, choices in found.items()}
    best = max(matches, key=lambda match: _likeness(scene, masks, match.curve))
    silhouettes = {name: choices[0] for name, choices in found.items()} | best.silhouettes
    return ColdStart(best.curve, Stages(silhouettes, best.points_mm, best.gaps_mm))


@dataclass(frozen=True)
class Match:
    """One midline of each of two cameras taken together: the paired rays' points (n, 3), their gaps (n,), and the curve."""

    silhouettes: dict[str, Silhouette]
    points_mm: FloatArray
    gaps_mm: FloatArray
    curve: Curve


def _likeness(scene: Scene, masks: Mapping[str, Mask], line: Curve) -> float:
    """How much of the silhouettes and of the curve's tube lies in both (1: all), less the relative error of the length."""
    shares = []
    for camera in scene.cameras:
        tube, _ = tube_mask(camera, line, Grid.of(camera.size_px))
        shares.append(
            np.count_nonzero(tube & masks[camera.name]) / np.count_nonzero(tube | masks[camera.name])
        )
    off = 0.0 if scene.length_mm is None else abs(line.length_mm / scene.length_mm - 1.0)
    return float(np.mean(shares)) - off


def matched(
    pair: tuple[Camera, Camera], silhouettes: tuple[Silhouette, ...], base_mm: FloatArray | None
) -> Match:
    """Two cameras' midlines from base to tip taken together; `base_mm` (3,) is the base, None where it is not known."""
    first, second = pair
    rays = [camera.rays(_evened(seen)) for camera, seen in zip(pair, silhouettes, strict=True)]
    i, j = ordered_pairs(ray_gaps(first, rays[0], second, rays[1]))
    points, gaps = triangulate(first, rays[0][i], second, rays[1][j])
    walk = (i + j) / (2.0 * (MIDLINE_POINTS - 1))
    radius = silhouettes[0].half_width_px / _px_per_mm(first, points)
    seen = {camera.name: silhouette for camera, silhouette in zip(pair, silhouettes, strict=True)}
    return Match(seen, points, gaps, _first_curve(points, walk, base_mm, radius))


def _silhouettes(
    camera: Camera, picture: Picture, backdrop: Backdrop, insertion_mm: float, limits: Limits
) -> tuple[Silhouette, ...]:
    """The robot's mask in a picture with each of the lines that may be its midline."""
    base, grid = BaseView.of(camera, insertion_mm), backdrop.grid
    mask = robot_mask(camera.name, picture.reduced(grid.step), backdrop, base, limits)
    least_px = LEAST_LENGTH_MM * base.px_per_mm
    lines = [line for line in midlines(mask, base.pixel) if curve.arc_lengths(line)[-1] > least_px]
    if not lines:
        raise RefusedError(
            f"camera {camera.name}: the robot's silhouette is less than {LEAST_LENGTH_MM:g} mm long"
        )
    width = half_width(mask) * grid.step
    return tuple(Silhouette(mask, grid.fine(line), width) for line in lines)


def _evened(silhouette: Silhouette) -> FloatArray:
    """The midline (MIDLINE_POINTS, 2) in px: the skeleton evenly spaced; its last half width, where it runs into a corner
    of the end, goes straight on instead.
    """
    skeleton, width = silhouette.skeleton, silhouette.half_width_px
    even = curve.resample(skeleton, 2 * MIDLINE_POINTS)
    arc = curve.arc_lengths(even)
    kept = even[arc <= max(arc[-1] - width, arc[-1] / 2)]
    onwards = kept[-1] - kept[-min(8, len(kept))]
    onwards = onwards / max(float(np.linalg.norm(onwards)), 1e-9)
    return curve.resample(np.vstack([kept, kept[-1] + onwards * width]), MIDLINE_POINTS)


def _first_curve(points: FloatArray, walk: FloatArray, base_mm: FloatArray | None, radius_mm: float) -> Curve:
    """A smooth curve from the base through triangulated points, its parameter brought to arc length."""
    far = walk > BASE_STRETCH
    base = np.empty((0, 3)) if base_mm is None else np.tile(base_mm, (3, 1))
    places = np.vstack([base, points[far]])
    parameter = np.concatenate([np.zeros(len(base)), walk[far]])
    control = curve.fit_points(places, parameter)
    for _ in range(3):
        arc = curve.arc_lengths(curve.POSITION @ control)
        parameter = np.interp(parameter, curve.PARAMETER, arc / arc[-1])
        control = curve.fit_points(places, parameter)
    length = float(curve.arc_lengths(curve.POSITION @ control)[-1])
    return Curve(control, length, np.full(curve.SAMPLES, radius_mm))


def _px_per_mm(camera: Camera, points: FloatArray) -> float:
    _, jacobian = camera.project_with_jacobian(points[len(points) // 2 :][:1])
    return float(np.linalg.svd(jacobian[0], compute_uv=False)[0])
