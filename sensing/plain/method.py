"""The paper's steps one after another."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sensing.geometry.camera import Camera
from sensing.geometry.rays import best_pair
from sensing.pictures.grid import Grid
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import BaseView, Mask
from sensing.plain.judging import judge
from sensing.plain.silhouette import reaches_rim, silhouette
from sensing.plain.skeleton import skeleton
from sensing.plain.trace import traced
from sensing.refined.track import Track
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape, Silhouette, Stages
from sensing.stopwatch import Stopwatch


@dataclass(frozen=True)
class Plain:
    """Every set of pictures by itself; the set before is of no use to it. See `sensing.method.Method`."""

    name: ClassVar[MethodName] = MethodName.PLAIN

    scene: Scene

    def estimate(
        self,
        pictures: Mapping[str, Picture],
        insertion_mm: float,
        last: Track | None,  # noqa: ARG002  the interface's
        clock: Callable[[], float],
    ) -> Shape:
        """Steps 1 to 9; of more than two cameras all are segmented and compared, and the best two triangulate."""
        watch = Stopwatch(clock)
        cameras = self.scene.cameras
        for camera in cameras:
            _ = pictures[camera.name].colour
        watch.lap("decode")
        bases = {
            camera.name: BaseView.of(camera, insertion_mm, Grid(camera.size_px, 1)) for camera in cameras
        }
        masks = {
            camera.name: self._mask(camera, pictures[camera.name], bases[camera.name]) for camera in cameras
        }
        watch.lap("segment")
        skeletons = {name: skeleton(mask, bases[name].pixel) for name, mask in masks.items()}
        watch.lap("skeleton")
        pair = best_pair(cameras, np.array([0.0, 0.0, insertion_mm]))
        trace = traced(pair, skeletons, masks, insertion_mm)
        watch.lap("triangulate")
        rims = [reaches_rim(mask, self.scene.work_areas.get(name)) for name, mask in masks.items()]
        evidence = judge(cameras, skeletons, trace, self.scene.length_mm, cut_off=any(rims))
        watch.lap("judge")
        silhouettes = {
            name: Silhouette(masks[name], found.pixels, found.half_width_px)
            for name, found in skeletons.items()
        }
        return Shape(
            centreline=trace.line,
            insertion_mm=insertion_mm,
            evidence=evidence,
            stages=Stages(silhouettes, trace.points_mm, np.abs(trace.gaps_mm)),
            track=None,
            stage_s=watch.laps,
        )

    def _mask(self, camera: Camera, picture: Picture, base: BaseView) -> Mask:
        return silhouette(
            camera,
            picture.colour,
            self.scene.backdrop(picture).picture,
            base,
            holder_radius_mm=self.scene.holder_radius_mm,
            work_area=self.scene.work_areas.get(camera.name),
            threshold=self.scene.threshold,
        )
