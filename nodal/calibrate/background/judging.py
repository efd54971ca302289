"""Whether a scene without the robot makes a good background: light, glare, edges, a robot that was forgotten. Pure."""

from collections.abc import Iterator

import msgspec
import numpy as np

from messaging.checked import FloatArray
from nodal.calibrate.background.area import Mask, Reach, holder_mask, reach_mask, work_area
from nodal.calibrate.background.spots import SHARP, Backing, Spot, sharpness
from nodal.calibrate.background.statistics import Statistics
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image, luma
from sensing.pictures.segmentation import BaseView, Limits, robot_mask

CLIPPED = 250
FORGOTTEN_MM = 15.0
"""What stands at the base and is taller than this is a robot."""
USUAL_PX_PER_MM = 3.7
"""Detection pixels, where the camera's calibration is not known."""


class CameraBackground(msgspec.Struct, frozen=True, kw_only=True):
    """What one camera's pictures without the robot tell. Colours are R, G, B in levels.

    `noise` is a pixel's standard deviation in one picture, `tile_noise` its usual one over the picture's tiles, `noisiest_px` and
    `noisiest` where it is strongest and how strong; `flicker` the standard deviation of whole pictures' brightness over its mean,
    `unevenness` the range of the backdrop's brightness within reach over its mean, `clipped_share` the share of it that is too bright to
    be told. `work_area` are corners in px; `ends_in_reach` is true where the backdrop ends within the robot's reach.
    """

    camera: str
    pictures: int
    level: tuple[float, float, float]
    noise: tuple[float, float, float]
    tile_noise: float
    noisiest: float
    noisiest_px: tuple[int, int]
    flicker: float
    unevenness: float
    clipped_share: float
    spots: tuple[Spot, ...]
    ends_in_reach: bool
    work_area: tuple[tuple[float, float], ...] | None


def judged(
    name: str, statistics: Statistics, camera: Camera | None, reach: Reach, insertion_mm: float
) -> CameraBackground:
    """Of one camera; without its calibration (`camera`) there is no work area, and the whole picture is looked at."""
    height, width = statistics.mean.shape[:2]
    grid, px_per_mm = Grid.of((width, height)), USUAL_PX_PER_MM
    looked, elsewhere = np.full(grid.shape, 255, dtype=np.uint8), np.full(grid.shape, 255, dtype=np.uint8)
    if camera is not None:
        elsewhere = ~holder_mask(camera, reach, insertion_mm)
        looked = reach_mask(camera, reach) & elsewhere
        px_per_mm = float(BaseView.of(camera, insertion_mm, grid).px_per_mm)
    backing = Backing.of(statistics, elsewhere)
    beyond = backing.beyond(looked)
    area = None if camera is None else work_area(camera, reach, beyond)
    backdrop = backing.small[looked > 0]
    painted = luma(backing.surface)[looked > 0].astype(np.float64)
    noise, (rows, columns) = statistics.tile_noise, statistics.tile_noise.shape
    row, column = divmod(int(noise.argmax()), columns)
    return CameraBackground(
        camera=name,
        pictures=statistics.count,
        level=_rgb(backdrop.mean(axis=0)),
        noise=_rgb(statistics.noise),
        tile_noise=float(np.median(noise)),
        noisiest=float(noise.max()),
        noisiest_px=(int((column + 0.5) * width / columns), int((row + 0.5) * height / rows)),
        flicker=statistics.flicker,
        unevenness=float(np.ptp(painted) / max(painted.mean(), 1.0)),
        clipped_share=float((backdrop.max(axis=1) >= CLIPPED).mean()),
        spots=tuple(backing.spots(looked, beyond, px_per_mm**-2, grid.step)),
        ends_in_reach=bool((beyond & looked).any()),
        work_area=None if area is None else tuple((float(x), float(y)) for x, y in area),
    )


def refusals(
    statistics: Statistics, camera: Camera | None, reach: Reach, insertion_mm: float, *, stage_heard: bool
) -> Iterator[str]:
    """Why these are no pictures of an empty scene; `insertion_mm` is an assumption where the stage was not heard."""
    if statistics.stirred:
        x, y, width, height = max(statistics.stirred, key=lambda box: box[2] * box[3])
        yield (
            f"something moved while the pictures were taken, about {x + width // 2}, {y + height // 2} px; step back and take "
            "them again"
        )
    if camera is not None:
        small = Grid.of(camera.size_px).reduced(statistics.mean)
        above_mm = _standing_mm(camera, small, reach, insertion_mm)
        if above_mm > FORGOTTEN_MM:
            unheard = (
                f" Or is the stage raised? It was not heard, and is taken to stand at {insertion_mm:g} mm: lower it, or start "
                "`nodal control`, which says where it stands"
            )
            yield (
                f"something {above_mm:.0f} mm tall stands where the robot begins: is the robot still in its holder?"
                f"{'' if stage_heard else unheard}"
            )


def _standing_mm(camera: Camera, small: Image, reach: Reach, insertion_mm: float) -> float:
    """How far what stands at the base reaches up; 0 for nothing, or a soft shadow."""
    grid = Grid.of(camera.size_px)
    base, backdrop = BaseView.of(camera, insertion_mm, grid), Backdrop.fitted(small, grid)
    try:
        mask: Mask = robot_mask(
            camera.name, small, backdrop, base, Limits(reach.holder_radius_mm, reach.length_mm)
        )
    except RefusedError:
        return 0.0
    if sharpness(backdrop.distance(small), mask) < SHARP:
        return 0.0
    rows, columns = np.nonzero(mask)
    return float(((np.column_stack([columns, rows]) - base.pixel) @ base.up).max()) / base.px_per_mm


def _rgb(bgr: FloatArray) -> tuple[float, float, float]:
    blue, green, red = (float(value) for value in bgr)
    return red, green, blue
