"""The robot's midline in the rig frame, from pictures alone: sensing's refined method without a base to begin at.

The tube is measured as in closed loop, but where it begins follows from its tip and from its known length.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from messaging.checked import FloatArray
from nodal.calibrate.base.silhouettes import Moving, moving, robot_midline
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.geometry.rays import best_pair
from sensing.pictures.picture import Picture
from sensing.refined.cold_start import matched
from sensing.refined.measuring import View
from sensing.refined.method import COLD
from sensing.refined.quality import LARGE_RESIDUAL_PX, LEAST_ENDS, LEAST_EXPLAINED, residual_px
from sensing.refined.refinement import Fit, Prior, refine
from sensing.refined.tube import Tip
from sensing.scene import Scene
from sensing.shape import Silhouette


@dataclass(frozen=True)
class Midline:
    """A midline (n, 3) in mm in the scene's frame at even steps from base to tip, and its RMS residual in px by camera.

    `misfit` tells how badly the assumed tip explains the pictures.
    """

    points_mm: FloatArray
    residual_px: Mapping[str, float]
    misfit: float


Midlines = Mapping[Tip, Midline]
"""For each way in which the robot may end."""


class MidlineFinder:
    """Finds midlines of a robot of known length in pictures of a scene in any frame."""

    def __init__(self, scene: Scene, length_mm: float, bent: Sequence[Mapping[str, Picture]]) -> None:
        """`bent` are sets of pictures of the robot bent in several ways over one base; raises CalibrationError."""
        self._scene = scene
        self._prior = Prior(0.0, length_mm, base_spread_mm=math.inf, base_spread_rad=math.inf)
        self._moved: dict[str, Moving] = {
            camera.name: moving(camera, scene, [pictures[camera.name] for pictures in bent])
            for camera in scene.cameras
        }

    def find(self, pictures: Mapping[str, Picture]) -> Midlines:
        """The midline for each way in which the robot may end; raises RefusedError when it is not seen well."""
        cameras = self._scene.cameras
        found = {
            camera.name: robot_midline(camera, self._scene, pictures[camera.name], self._moved[camera.name])
            for camera in cameras
        }
        silhouettes = {name: silhouette for name, (silhouette, _) in found.items()}
        pair = best_pair(cameras, _middle_mm(cameras, silhouettes))
        start = matched(pair, tuple(silhouettes[camera.name] for camera in pair), None).curve
        views = tuple(
            View(camera, pictures[camera.name].luma, found[camera.name][1].luma, np.zeros(2))
            for camera in cameras
        )
        fits = {tip: refine(views, start, self._prior, tip, COLD) for tip in Tip}
        _check(min(fits.values(), key=lambda fit: fit.misfit), cameras)
        return {tip: _midline(fit, cameras) for tip, fit in fits.items()}


def _middle_mm(cameras: Sequence[Camera], silhouettes: Mapping[str, Silhouette]) -> FloatArray:
    """The point (3,) nearest to the rays through the middles of all silhouettes."""
    matrix, vector = np.zeros((3, 3)), np.zeros(3)
    for camera in cameras:
        ray = camera.rays(silhouettes[camera.name].skeleton.mean(axis=0, keepdims=True))[0]
        across = np.eye(3) - np.outer(ray, ray)
        matrix += across
        vector += across @ camera.centre_mm
    return np.asarray(np.linalg.solve(matrix, vector))


def _check(fit: Fit, cameras: Sequence[Camera]) -> None:
    """Raises RefusedError for a fit that says little about where the robot begins and ends."""
    residual = residual_px(fit.normals.residual_px[fit.normals.valid])
    if not residual < LARGE_RESIDUAL_PX:
        raise RefusedError(f"the cameras disagree about the robot's midline by {residual:.2f} px")
    for camera, share in zip(cameras, fit.normals.valid.mean(axis=1), strict=True):
        if share < LEAST_EXPLAINED:
            raise RefusedError(
                f"camera {camera.name}: only {100 * share:.0f} % of the robot's edges are seen"
            )
    if np.count_nonzero(fit.ends.seen) < LEAST_ENDS:
        raise RefusedError("fewer than two cameras see the robot's tip")


def _midline(fit: Fit, cameras: Sequence[Camera]) -> Midline:
    measured = zip(cameras, fit.normals.residual_px, fit.normals.valid, strict=True)
    return Midline(
        points_mm=fit.curve.points_mm,
        residual_px={camera.name: residual_px(off[valid]) for camera, off, valid in measured},
        misfit=fit.misfit,
    )
