"""Settings of the simulated cameras: what they look at, and everything that makes a real picture less than ideal.

Colours are red, green, blue in levels of 0 to 255. Every strength may be zero.
"""

from typing import Annotated

import msgspec

Length = Annotated[float, msgspec.Meta(gt=0, le=1000)]
Fraction = Annotated[float, msgspec.Meta(ge=0, le=1)]
Level = Annotated[int, msgspec.Meta(ge=0, le=255)]
Colour = tuple[Level, Level, Level]


class BodySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What of the robot is seen: a round tube for each section, spacer disks around it, and the holder below its base."""

    diameter_mm: Annotated[tuple[Length, ...], msgspec.Meta(min_length=1, max_length=8)] = (6.0, 5.0)
    """One for each section, from the base; the tip is a half sphere."""
    tube_colour: Annotated[tuple[Colour, ...], msgspec.Meta(min_length=1, max_length=8)] = (
        (88, 88, 132),
        (86, 86, 94),
    )
    disk_spacing_mm: Length = 8.0
    disk_thickness_mm: Length = 1.0
    disk_proud_mm: Annotated[float, msgspec.Meta(ge=0, le=20)] = 0.6
    disk_colour: Colour = (76, 76, 82)
    collar_diameter_mm: Length = 16.0
    collar_height_mm: Length = 16.0
    block_mm: tuple[Length, Length, Length] = (30.0, 22.0, 18.0)
    """The block below the collar: along x, y and z."""
    holder_colour: Colour = (84, 84, 88)

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if len(self.tube_colour) != len(self.diameter_mm):
            raise ValueError(
                f"tube_colour has {len(self.tube_colour)} colours; it needs one for each of the "
                f"{len(self.diameter_mm)} sections in diameter_mm"
            )


class LightSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The backdrop and the light on it, and on the robot."""

    backdrop_colour: Colour = (64, 150, 82)
    gradient: Fraction = 0.18
    """How much darker the backdrop's corners are than its middle."""
    shadow: Fraction = 0.10
    """How dark the soft shadow on the backdrop is at its deepest."""
    ambient: Fraction = 0.45
    """Share of the light that comes from everywhere; the rest comes from `direction` and shades what it meets."""
    direction: tuple[float, float, float] = (-0.35, -0.55, 0.76)
    """Towards the lamp, in the robot frame."""


class SensorSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How a camera takes its pictures, and when."""

    rate_hz: Annotated[float, msgspec.Meta(ge=1, le=60)] = 30.0
    exposure_s: Annotated[float, msgspec.Meta(ge=0, le=0.015)] = 0.006
    """The robot is blurred by its motion within this time; the capture time is its middle."""
    lens_blur_px: Annotated[float, msgspec.Meta(ge=0, le=20)] = 1.0
    noise_levels: Annotated[float, msgspec.Meta(ge=0, le=30)] = 2.0
    """Standard deviation in every pixel and channel."""
    jpeg_quality: Annotated[int, msgspec.Meta(ge=30, le=100)] = 80
    phase_s: Annotated[float, msgspec.Meta(ge=0, le=0.01)] = 0.003
    """Each camera keeps its own phase, drawn once from plus or minus this much."""
    jitter_s: Annotated[float, msgspec.Meta(ge=0, le=0.001)] = 0.0001
    """Standard deviation of single capture times about the camera's own raster."""


class SimulatedCamerasSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """All simulated cameras of a bench; where they stand is said by the bench's calibration."""

    body: BodySettings = BodySettings()
    light: LightSettings = LightSettings()
    sensor: SensorSettings = SensorSettings()
