"""From one set of pictures to the robot's shape, with or without a prior.

With the last shape as prior the curve is refined at once, from brightness along short normals, and what the cameras see
in and around it is held against it. Without one, or when that fit does not convince, the robot is found anew
(`cold_start`); a shape that does not convince then is flagged, and no prior for the next.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import ClassVar

import numpy as np

from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.grid import Grid
from sensing.pictures.picture import Picture
from sensing.refined import quality
from sensing.refined.cold_start import ColdStart, cold_start
from sensing.refined.fitted_line import FittedLine
from sensing.refined.measuring import View
from sensing.refined.refinement import Fit, Patience, Prior, refine
from sensing.refined.surroundings import look_around
from sensing.refined.track import Track
from sensing.refined.tube import Curve, Tip
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape, Stages
from sensing.stopwatch import Stopwatch

AROUND_MM = 10.0
"""Around the expected curve: the tube's half width, the reach of normals, and how far it may have moved."""
COLD = Patience(rounds=8, enough_mm=0.01)
WARM = Patience(rounds=4, enough_mm=0.5)


@dataclass(frozen=True)
class Refined:
    """The default method; see `sensing.method.Method`."""

    name: ClassVar[MethodName] = MethodName.REFINED

    scene: Scene

    def estimate(
        self,
        pictures: Mapping[str, Picture],
        insertion_mm: float,
        last: Track | None,
        clock: Callable[[], float],
    ) -> Shape:
        """Refine the last shape; where there is none, or where that does not convince, find the robot anew."""
        watch = Stopwatch(clock)
        # a camera that was lost when the robot was found has no backdrop yet
        if last is not None and all(camera.name in last.backdrops for camera in self.scene.cameras):
            warm = self._warm(pictures, insertion_mm, last, watch)
            if not warm.flags:
                return replace(warm, stage_s=watch.laps)
        try:
            cold = self._cold(self.scene, pictures, insertion_mm, watch)
        except RefusedError:
            self._refuse_swapped(pictures, insertion_mm, watch)
            raise
        if cold.flags:
            self._refuse_swapped(pictures, insertion_mm, watch)
            cold = replace(cold, track=None)
        return replace(cold, stage_s=watch.laps)

    def _refuse_swapped(self, pictures: Mapping[str, Picture], insertion_mm: float, watch: Stopwatch) -> None:
        """Raises RefusedError naming two cameras whose pictures make a good shape once they are exchanged."""
        unknown = replace(self.scene, backdrops={})
        for one, other in combinations(self.scene.cameras, 2):
            if one.size_px != other.size_px:
                continue
            exchanged = {**pictures, one.name: pictures[other.name], other.name: pictures[one.name]}
            try:
                flags = self._cold(unknown, exchanged, insertion_mm, watch).flags
            except RefusedError:
                continue
            if not flags:
                raise RefusedError(
                    f"cameras {one.name} and {other.name} seem to be swapped: exchanged, their pictures agree"
                )

    def _cold(
        self, scene: Scene, pictures: Mapping[str, Picture], insertion_mm: float, watch: Stopwatch
    ) -> Shape:
        for camera in scene.cameras:
            _ = pictures[camera.name].reduced(Grid.of(camera.size_px).step)
        watch.lap("decode")
        backdrops = {camera.name: scene.backdrop(pictures[camera.name]) for camera in scene.cameras}
        watch.lap("backdrop")
        found = cold_start(scene, pictures, backdrops, insertion_mm)
        watch.lap("cold_start")
        views = tuple(
            View(camera, pictures[camera.name].luma, backdrops[camera.name].luma, np.zeros(2))
            for camera in scene.cameras
        )
        prior = Prior(insertion_mm, scene.length_mm)
        fits = {tip: refine(views, found.curve, prior, tip, COLD) for tip in Tip}
        tip = min(fits, key=lambda kind: fits[kind].misfit)
        watch.lap("refine")
        track = Track(fits[tip].curve, tip, insertion_mm, backdrops)
        shape = self._judged(fits[tip], track, prior, views, found)
        if not math.isfinite(shape.evidence.ray_gap_mm):
            raise RefusedError("no two cameras see the same stretch of the robot where the curve says it is")
        watch.lap("judge")
        return shape

    def _warm(
        self, pictures: Mapping[str, Picture], insertion_mm: float, last: Track, watch: Stopwatch
    ) -> Shape:
        lift = np.array([0.0, 0.0, insertion_mm - last.insertion_mm])
        start = Curve(last.curve.control_mm + lift, last.curve.length_mm, last.curve.radius_mm)
        prior = Prior(insertion_mm, self.scene.length_mm)
        views = tuple(
            _view_around(camera, pictures[camera.name], last.backdrops[camera.name], start)
            for camera in self.scene.cameras
        )
        watch.lap("decode")
        fit = refine(views, start, prior, last.tip, WARM)
        watch.lap("refine")
        track = Track(fit.curve, last.tip, insertion_mm, last.backdrops)
        shape = self._judged(fit, track, prior, views, None)
        watch.lap("judge")
        return shape

    def _judged(
        self, fit: Fit, track: Track, prior: Prior, views: tuple[View, ...], found: ColdStart | None
    ) -> Shape:
        stages: Stages | None = None if found is None else found.stages
        masks = {} if stages is None else {name: seen.mask for name, seen in stages.silhouettes.items()}
        around = look_around(views, track, self.scene.holder_radius_mm)
        return Shape(
            centreline=FittedLine(fit),
            insertion_mm=prior.insertion_mm,
            evidence=quality.judge(self.scene.cameras, fit, prior, around, masks),
            stages=stages,
            track=track,
            stage_s={},
        )


def _view_around(camera: Camera, picture: Picture, backdrop: Backdrop, expected: Curve) -> View:
    """The part of a picture in which an expected curve is looked for."""
    pixels, by_point = camera.project_with_jacobian(expected.points_mm)
    around = AROUND_MM * float(np.linalg.norm(by_point, axis=(1, 2)).max()) / math.sqrt(2.0)
    low, high = np.floor(pixels.min(axis=0) - around), np.ceil(pixels.max(axis=0) + around)
    luma, (left, top, right, bottom) = picture.luma_around(
        (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
    )
    return View(camera, luma, backdrop.luma[top:bottom, left:right], np.array([left, top], dtype=np.float64))
