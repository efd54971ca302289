"""What does not change from frame to frame: the cameras, what they see without the robot, and what is known of the robot."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from messaging.checked import FloatArray
from messaging.frames import CameraCalibration
from messaging.settings import RobotSettings
from sensing.errors import WorkAreaError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.grid import Grid
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import Limits
from sensing.pictures.work_area import work_area_faults
from sensing.settings import HOLDER_RADIUS_MM, SensingSettings


@dataclass(frozen=True)
class Scene:
    """Cameras without a backdrop get one fitted to their first picture.

    `work_areas` are polygons (n, 2) in px, by camera: the robot is looked for inside alone. `threshold` is equation 1's T
    in levels; without it, it follows from the noise and the contrast.
    """

    cameras: tuple[Camera, ...]
    backdrops: Mapping[str, Backdrop]
    length_mm: float | None
    holder_radius_mm: float
    work_areas: Mapping[str, FloatArray] = field(default_factory=dict)
    threshold: float | None = None

    @classmethod
    def of(
        cls,
        calibrations: tuple[CameraCalibration, ...],
        *,
        backgrounds: Mapping[str, bytes] | None = None,
        colour_rgb: tuple[float, float, float] | None = None,
        length_mm: float | None = None,
        holder_radius_mm: float = HOLDER_RADIUS_MM,
        work_areas: Mapping[str, FloatArray] | None = None,
        threshold: float | None = None,
    ) -> "Scene":
        """The scene of these cameras; `backgrounds` are coded pictures without the robot, by camera.

        Where there is none, `colour_rgb` stands in, if given. Raises UnreadableImageError or ImageSizeError, and
        WorkAreaError for a work area of no camera, beyond the picture or without the base.
        """
        areas = {name: np.asarray(corners, dtype=np.float64) for name, corners in (work_areas or {}).items()}
        if faults := list(work_area_faults(areas, calibrations)):
            raise WorkAreaError("; ".join(faults))
        backdrops = {}
        for calibration in calibrations:
            size = calibration.width_px, calibration.height_px
            if data := (backgrounds or {}).get(calibration.camera):
                backdrops[calibration.camera] = Backdrop.from_picture(
                    Picture(calibration.camera, data, size).colour
                )
            elif colour_rgb is not None:
                backdrops[calibration.camera] = Backdrop.from_colour(colour_rgb[::-1], size)
        return cls(
            cameras=tuple(map(Camera, calibrations)),
            backdrops=backdrops,
            length_mm=length_mm,
            holder_radius_mm=holder_radius_mm,
            work_areas=areas,
            threshold=threshold,
        )

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
            calibrations,
            backgrounds=backgrounds,
            colour_rgb=settings.backdrop_colour,
            length_mm=robot.length_mm,
            holder_radius_mm=settings.holder_radius_mm,
            work_areas={name: np.array(corners) for name, corners in settings.work_area.items()},
            threshold=settings.threshold,
        )

    def without(self, cameras: Collection[str]) -> Self:
        """The scene as the other cameras see it."""
        return replace(self, cameras=tuple(camera for camera in self.cameras if camera.name not in cameras))

    def limits(self, camera: str) -> Limits:
        """Where the robot can be in a camera's pictures."""
        return Limits(self.holder_radius_mm, self.length_mm, self.work_areas.get(camera), self.threshold)

    def backdrop(self, picture: Picture) -> Backdrop:
        """What a picture's camera would see without the robot, in the picture's own light; raises UnreadableImageError."""
        known = self.backdrops.get(picture.camera)
        if known is None:
            grid = Grid.of(picture.size_px)
            return Backdrop.fitted(picture.reduced(grid.step), grid)
        return known.in_light_of(picture.reduced(known.grid.step))

    def picture(self, camera: str, data: bytes) -> Picture:
        """The coded picture of one of the cameras; raises UnreadableImageError or ImageSizeError."""
        size = next(known.size_px for known in self.cameras if known.name == camera)
        return Picture(camera, data, size)
