"""Settings of a camera that Linux offers by V4L2: a webcam, for one."""

from typing import Annotated, Literal

import msgspec

Level = Annotated[int, msgspec.Meta(ge=-65_536, le=65_536)]
ArcSeconds = Annotated[int, msgspec.Meta(ge=-648_000, le=648_000)]


class V4l2Controls(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the camera must not choose by itself. A control without a value stays as it is, but all that would change it
    is switched off: automatic exposure, gain, focus and white balance, a frame rate that drops in the dark, backlight
    compensation. Values without a unit are the camera's own numbers; `nodal cameras list` gives their ranges.
    """

    exposure_s: Annotated[float, msgspec.Meta(ge=0.0001, le=10)] | None = None
    """Exposure time. Cameras count it in steps of 0.0001 s; well below the time in which the robot moves by a pixel."""
    gain: Level | None = None
    focus: Level | None = None
    """The nearer, the larger (`focus_absolute`). Calibration holds for one focus only."""
    white_balance_k: Annotated[int, msgspec.Meta(ge=1000, le=20_000)] | None = None
    """Colour temperature of the light in kelvin."""
    power_line_hz: Literal[0, 50, 60] | None = None
    """Mains frequency that the camera suppresses the flicker of; 0 for none."""
    sharpness: Level | None = None
    brightness: Level | None = None
    contrast: Level | None = None
    saturation: Level | None = None
    zoom: Level | None = None
    """Calibration holds for one zoom only, and for one pan and tilt, which cameras without motors cut out of the picture."""
    pan: ArcSeconds | None = None
    tilt: ArcSeconds | None = None


class V4l2CameraSettings(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="source", tag="v4l2"
):
    """A camera that Linux offers by V4L2 (`source = "v4l2"`). Its own JPEG pictures are kept as they are. docs/cameras.md
    says what happens when it fails.
    """

    device: Annotated[str, msgspec.Meta(pattern="^/")]
    """A path that stays the same over restarts, such as `/dev/v4l/by-path/...-video-index0`; `nodal cameras list` shows it."""
    width_px: Annotated[int, msgspec.Meta(ge=16, le=16_384)] = 1920
    height_px: Annotated[int, msgspec.Meta(ge=16, le=16_384)] = 1080
    rate_hz: Annotated[float, msgspec.Meta(gt=0, le=1000)] = 30.0
    controls: V4l2Controls = V4l2Controls()
