"""From one set of pictures to the robot's shape: the whole of METHOD, pure, with or without a prior.

With the last shape as prior the curve is refined at once, from brightness along short normals, and nothing else is
looked at. Without one, or when that fit does not convince, the robot is found anew (`cold_start`).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from messaging.checked import FloatArray
from messaging.frames import CameraCalibration
from messaging.settings import RobotSettings
from messaging.shape import Flag, NodalPoints
from sensing import curve, quality
from sensing.backdrop import Backdrop
from sensing.camera import Camera
from sensing.cold_start import ColdStart, cold_start
from sensing.errors import NodalPointError, RefusedError
from sensing.picture import Picture
from sensing.refinement import Curve, Fit, Patience, Prior, Tip, View, refine
from sensing.settings import SensingSettings

AROUND_PX = 80
"""Around the expected curve: the tube's half width, the reach of normals, and how far it may have moved."""
COLD = Patience(rounds=8, enough_mm=0.01)
WARM = Patience(rounds=4, enough_mm=0.5)
BEYOND_TIP_MM = 1.0
"""A nodal point may lie this far beyond the measured tip, or a fiftieth of the length: there the line goes straight on."""


@dataclass(frozen=True)
class Scene:
    """What does not change from frame to frame. Cameras without a backdrop get one fitted to their first picture."""

    cameras: tuple[Camera, ...]
    backdrops: Mapping[str, Backdrop]
    length_mm: float | None
    holder_radius_mm: float

    @classmethod
    def of(
        cls,
        calibrations: tuple[CameraCalibration, ...],
        backgrounds: Mapping[str, bytes],
        colour_rgb: tuple[float, float, float] | None,
        length_mm: float | None,
        holder_radius_mm: float,
    ) -> "Scene":
        """The scene of these cameras; `backgrounds` are coded pictures without the robot, by camera.

        Where there is none, `colour_rgb` stands in, if given. Raises UnreadableImageError or ImageSizeError.
        """
        backdrops = {}
        for calibration in calibrations:
            size = calibration.width_px, calibration.height_px
            if data := backgrounds.get(calibration.camera):
                backdrops[calibration.camera] = Backdrop.from_picture(
                    Picture(calibration.camera, data, size).colour
                )
            elif colour_rgb is not None:
                backdrops[calibration.camera] = Backdrop.from_colour(colour_rgb[::-1], size)
        return cls(tuple(map(Camera, calibrations)), backdrops, length_mm, holder_radius_mm)

    @classmethod
    def on_bench(
        cls,
        settings: SensingSettings,
        robot: RobotSettings,
        calibrations: tuple[CameraCalibration, ...],
        backgrounds: Mapping[str, bytes],
    ) -> "Scene":
        """The scene that a bench file describes; raises as `of` does."""
        return cls.of(
            calibrations, backgrounds, settings.backdrop_colour, robot.length_mm, settings.holder_radius_mm
        )

    def picture(self, camera: str, data: bytes) -> Picture:
        """The coded picture of one of the cameras; raises UnreadableImageError."""
        size = next(known.size_px for known in self.cameras if known.name == camera)
        return Picture(camera, data, size)


@dataclass(frozen=True)
class Track:
    """What the next frame set's estimate starts from: where the robot was seen last, and against which backdrops."""

    curve: Curve
    tip: Tip
    insertion_mm: float
    backdrops: Mapping[str, Backdrop]


@dataclass(frozen=True)
class Shape:
    """A resolved shape. `stages` are those of the cold start that began it, or None when it followed from a prior."""

    fit: Fit
    tip: Tip
    backdrops: Mapping[str, Backdrop]
    insertion_mm: float
    flags: tuple[Flag, ...]
    residual_px: float
    ray_gap_mm: float
    stages: ColdStart | None
    stage_s: Mapping[str, float]

    @property
    def track(self) -> Track:
        """What the next estimate needs of this one."""
        return Track(self.fit.curve, self.tip, self.insertion_mm, self.backdrops)

    @property
    def length_mm(self) -> float:
        """Measured length of the centreline."""
        return float(self.arc_mm[-1])

    @property
    def centreline_mm(self) -> FloatArray:
        """Centreline (curve.SAMPLES, 3) from base to tip."""
        return self.fit.curve.points_mm

    @property
    def arc_mm(self) -> FloatArray:
        """Distance from the base (curve.SAMPLES,) along the centreline."""
        return curve.arc_lengths(self.centreline_mm)

    def nodes(self, arc_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (n, 3) and covariances (n, 3, 3) of the points at these distances from the base (METHOD step 9).

        Raises NodalPointError for a point beyond the robot.
        """
        length = self.length_mm
        reach = length + max(BEYOND_TIP_MM, length / 50)
        if (arc_mm > reach).any():
            raise NodalPointError(
                f"nodal point at {arc_mm.max():g} mm is beyond the robot, whose centreline is {length:.2f} mm long"
            )
        control = self.fit.curve.control_mm
        line = curve.FINE_POSITION @ control
        basis = curve.basis(np.interp(arc_mm, curve.arc_lengths(line), curve.FINE_PARAMETER))
        tangent = line[-1] - line[-2]
        beyond = np.maximum(arc_mm - length, 0.0)[:, None] * (tangent / np.linalg.norm(tangent))
        return basis @ control + beyond, self.fit.covariance_mm2(basis)


def estimate(
    pictures: Mapping[str, Picture],
    scene: Scene,
    insertion_mm: float,
    last: Track | None,
    clock: Callable[[], float],
) -> Shape:
    """The shape in one set of pictures, one for each of the scene's cameras.

    `last` is the track of the set before, or None; `clock` gives seconds and is read only for `stage_s`. Raises
    RefusedError when no shape can be resolved, UnreadableImageError or ImageSizeError for a bad picture.
    """
    watch = _Stopwatch(clock)
    if last is not None:
        warm = _warm(pictures, scene, insertion_mm, last, watch)
        if not warm.flags:
            return replace(warm, stage_s=watch.laps)
    for camera in scene.cameras:
        _ = pictures[camera.name].colour
    watch.lap("decode")
    backdrops = {
        camera.name: scene.backdrops.get(camera.name) or Backdrop.fitted(pictures[camera.name].colour)
        for camera in scene.cameras
    }
    watch.lap("backdrop")
    stages = cold_start(scene.cameras, pictures, backdrops, insertion_mm, scene.holder_radius_mm)
    watch.lap("cold_start")
    views = tuple(
        View(camera, pictures[camera.name].luma, backdrops[camera.name].luma, np.zeros(2))
        for camera in scene.cameras
    )
    prior = Prior(insertion_mm, scene.length_mm)
    fits = {tip: refine(views, stages.curve, prior, tip, COLD) for tip in Tip}
    tip = min(fits, key=lambda kind: (fits[kind].outline_px, fits[kind].cost))
    watch.lap("refine")
    cold = _judged(fits[tip], tip, scene, prior, backdrops, stages)
    if not math.isfinite(cold.ray_gap_mm):
        raise RefusedError("no two cameras see the same stretch of the robot where the curve says it is")
    watch.lap("judge")
    return replace(cold, stage_s=watch.laps)


def covered_nodes(points: NodalPoints, length_mm: float) -> NodalPoints:
    """The same nodal points; raises NodalPointError for one beyond a robot of this length."""
    if points.arc_mm[-1] > length_mm:
        raise NodalPointError(
            f"nodal point {points.names[-1]} at {points.arc_mm[-1]:g} mm is beyond the robot; "
            f"allowed are 0 to {length_mm:g} mm"
        )
    return points


def _warm(
    pictures: Mapping[str, Picture], scene: Scene, insertion_mm: float, last: Track, watch: "_Stopwatch"
) -> Shape:
    lift = np.array([0.0, 0.0, insertion_mm - last.insertion_mm])
    start = Curve(last.curve.control_mm + lift, last.curve.length_mm, last.curve.radius_mm)
    prior = Prior(insertion_mm, scene.length_mm)
    views = tuple(
        _view_around(camera, pictures[camera.name], last.backdrops[camera.name], start)
        for camera in scene.cameras
    )
    watch.lap("decode")
    fit = refine(views, start, prior, last.tip, WARM)
    watch.lap("refine")
    shape = _judged(fit, last.tip, scene, prior, last.backdrops, None)
    watch.lap("judge")
    return shape


def _view_around(camera: Camera, picture: Picture, backdrop: Backdrop, expected: Curve) -> View:
    """The part of a picture in which an expected curve is looked for."""
    pixels = camera.project(expected.points_mm)
    low, high = np.floor(pixels.min(axis=0)) - AROUND_PX, np.ceil(pixels.max(axis=0)) + AROUND_PX
    luma, (left, top, right, bottom) = picture.luma_around(
        (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
    )
    return View(camera, luma, backdrop.luma[top:bottom, left:right], np.array([left, top], dtype=np.float64))


def _judged(
    fit: Fit,
    tip: Tip,
    scene: Scene,
    prior: Prior,
    backdrops: Mapping[str, Backdrop],
    stages: ColdStart | None,
) -> Shape:
    masks = {name: silhouette.mask for name, silhouette in stages.silhouettes.items()} if stages else {}
    verdict = quality.judge(scene.cameras, fit, prior, masks)
    return Shape(
        fit=fit,
        tip=tip,
        backdrops=backdrops,
        insertion_mm=prior.insertion_mm,
        flags=verdict.flags,
        residual_px=verdict.residual_px,
        ray_gap_mm=verdict.ray_gap_mm,
        stages=stages,
        stage_s={},
    )


class _Stopwatch:
    """Seconds spent between laps, added up by name."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._since = clock()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        now = self._clock()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._since
        self._since = now
