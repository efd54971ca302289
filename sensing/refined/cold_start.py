"""The robot's shape from nothing but pictures: METHOD steps 2 to 8, as the start of the refinement.

Each stage's result stays available, so that a picture of every step can be drawn.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.geometry.rays import best_pair, ray_gaps, triangulate
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import BaseView, Limits, robot_mask
from sensing.refined.midline import half_width, midline
from sensing.refined.tube import Curve
from sensing.refined.walk import ordered_pairs
from sensing.scene import Scene
from sensing.shape import Silhouette, Stages

MIDLINE_POINTS = 100
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
    silhouettes = {
        camera.name: _silhouette(
            camera, pictures[camera.name], backdrops[camera.name], insertion_mm, scene.limits(camera.name)
        )
        for camera in scene.cameras
    }
    first, second = best_pair(scene.cameras, np.array([0.0, 0.0, insertion_mm]))
    midlines = [_evened(silhouettes[camera.name]) for camera in (first, second)]
    rays = [camera.rays(midline) for camera, midline in zip((first, second), midlines, strict=True)]
    i, j = ordered_pairs(ray_gaps(first, rays[0], second, rays[1]))
    points, gaps = triangulate(first, rays[0][i], second, rays[1][j])
    walk = (i + j) / (2.0 * (MIDLINE_POINTS - 1))
    radius = silhouettes[first.name].half_width_px / _px_per_mm(first, points)
    return ColdStart(_first_curve(points, walk, insertion_mm, radius), Stages(silhouettes, points, gaps))


def _silhouette(
    camera: Camera, picture: Picture, backdrop: Backdrop, insertion_mm: float, limits: Limits
) -> Silhouette:
    base = BaseView.of(camera, insertion_mm)
    grid = backdrop.grid
    mask = robot_mask(camera.name, picture.reduced(grid.step), backdrop, base, limits)
    skeleton = midline(mask, base.pixel)
    if len(skeleton) < MIDLINE_POINTS // 5:
        raise RefusedError(
            f"camera {camera.name}: the robot's silhouette is only {len(skeleton) * grid.step} px long"
        )
    width = half_width(mask)
    return Silhouette(mask, grid.fine(skeleton), width * grid.step)


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


def _first_curve(points: FloatArray, walk: FloatArray, insertion_mm: float, radius_mm: float) -> Curve:
    """A smooth curve from the base through triangulated points, its parameter brought to arc length."""
    far = walk > BASE_STRETCH
    base = np.tile([0.0, 0.0, insertion_mm], (3, 1))
    places = np.vstack([base, points[far]])
    parameter = np.concatenate([np.zeros(3), walk[far]])
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
