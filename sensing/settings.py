"""Settings of sensing, as they stand in the bench file."""

from enum import StrEnum
from typing import Annotated

import msgspec
import numpy as np

from messaging.shape import NodalPoints

Pixel = Annotated[float, msgspec.Meta(ge=-1, le=20000)]
Level = Annotated[float, msgspec.Meta(ge=0, le=255)]


HOLDER_RADIUS_MM = 25.0


class MethodName(StrEnum):
    """How the shape is found: `refined`, from the edges in all cameras at once, or `plain`, the paper's steps."""

    REFINED = "refined"
    PLAIN = "plain"


class NodalPointSetting(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A point on the centreline, named by its distance from the base."""

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=40)]
    arc_mm: Annotated[float, msgspec.Meta(ge=0, le=2000)]


class SensingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What sensing looks for.

    The backdrop is, for each camera, a picture taken without the robot (`background`: camera name to file); failing
    that, one colour for all (`backdrop_colour` as R, G, B: equation 1 of the paper); failing that, a smooth surface
    fitted to the frames themselves. `work_area` holds, for each camera that needs one, the corners of a polygon in px:
    what lies outside is not looked at. It lies in the picture and contains the base. `threshold` is the colour distance T
    in levels of equation 1; without it, it follows from the noise and from how well the robot stands out. Within
    `holder_radius_mm` of the axis nothing below the base is taken for robot.
    """

    method: MethodName = MethodName.REFINED
    nodal_points: Annotated[tuple[NodalPointSetting, ...], msgspec.Meta(min_length=1, max_length=200)]
    background: dict[str, str] = {}
    backdrop_colour: tuple[Level, Level, Level] | None = None
    work_area: dict[str, Annotated[tuple[tuple[Pixel, Pixel], ...], msgspec.Meta(min_length=3)]] = {}
    threshold: Annotated[float, msgspec.Meta(gt=0, le=442)] | None = None
    holder_radius_mm: Annotated[float, msgspec.Meta(ge=0, le=500)] = HOLDER_RADIUS_MM
    maximum_skew_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.012
    stage_age_limit_s: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.5

    @property
    def points(self) -> NodalPoints:
        """The nodal points as a message."""
        return NodalPoints(
            names=tuple(point.name for point in self.nodal_points),
            arc_mm=np.array([point.arc_mm for point in self.nodal_points]),
        )
