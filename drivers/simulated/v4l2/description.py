"""What a Logitech C922 offers, as uvcvideo tells it."""

import dataclasses
from collections.abc import Mapping

from linuxpy.video.raw import ControlID, CtrlType, PixelFormat

Size = tuple[int, int]
MANUAL_EXPOSURE = 1


@dataclasses.dataclass(frozen=True, kw_only=True)
class ControlDescription:
    """One control. While `automatic` holds another value than `manual`, the camera sets this control itself."""

    id: ControlID
    name: str
    minimum: int = 0
    maximum: int = 255
    step: int = 1
    default: int = 128
    type: CtrlType = CtrlType.INTEGER
    menu: Mapping[int, str] = dataclasses.field(default_factory=dict)
    automatic: ControlID | None = None
    manual: int = 0


def _switch(control: ControlID, name: str, default: int) -> ControlDescription:
    return ControlDescription(id=control, name=name, maximum=1, default=default, type=CtrlType.BOOLEAN)


def _turn(control: ControlID, name: str) -> ControlDescription:
    """In seconds of arc."""
    return ControlDescription(id=control, name=name, minimum=-36_000, maximum=36_000, step=3600, default=0)


CONTROLS = (
    ControlDescription(id=ControlID.BRIGHTNESS, name="Brightness"),
    ControlDescription(id=ControlID.CONTRAST, name="Contrast"),
    ControlDescription(id=ControlID.SATURATION, name="Saturation"),
    _switch(ControlID.AUTO_WHITE_BALANCE, "White Balance, Automatic", 1),
    ControlDescription(id=ControlID.GAIN, name="Gain", default=0),
    ControlDescription(
        id=ControlID.POWER_LINE_FREQUENCY,
        name="Power Line Frequency",
        maximum=2,
        default=2,
        type=CtrlType.MENU,
        menu={0: "Disabled", 1: "50 Hz", 2: "60 Hz"},
    ),
    ControlDescription(
        id=ControlID.WHITE_BALANCE_TEMPERATURE,
        name="White Balance Temperature",
        minimum=2000,
        maximum=6500,
        default=4000,
        automatic=ControlID.AUTO_WHITE_BALANCE,
    ),
    ControlDescription(id=ControlID.SHARPNESS, name="Sharpness"),
    ControlDescription(
        id=ControlID.BACKLIGHT_COMPENSATION, name="Backlight Compensation", maximum=1, default=0
    ),
    ControlDescription(
        id=ControlID.EXPOSURE_AUTO,
        name="Auto Exposure",
        maximum=3,
        default=3,
        type=CtrlType.MENU,
        menu={1: "Manual Mode", 3: "Aperture Priority Mode"},
    ),
    ControlDescription(
        id=ControlID.EXPOSURE_ABSOLUTE,
        name="Exposure Time, Absolute",
        minimum=3,
        maximum=2047,
        default=250,
        automatic=ControlID.EXPOSURE_AUTO,
        manual=MANUAL_EXPOSURE,
    ),
    _switch(ControlID.EXPOSURE_AUTO_PRIORITY, "Exposure, Dynamic Framerate", 1),
    ControlDescription(
        id=ControlID.FOCUS_ABSOLUTE,
        name="Focus, Absolute",
        maximum=250,
        step=5,
        default=0,
        automatic=ControlID.FOCUS_AUTO,
    ),
    _switch(ControlID.FOCUS_AUTO, "Focus, Automatic Continuous", 1),
    ControlDescription(
        id=ControlID.ZOOM_ABSOLUTE, name="Zoom, Absolute", minimum=100, maximum=500, default=100
    ),
    _turn(ControlID.PAN_ABSOLUTE, "Pan, Absolute"),
    _turn(ControlID.TILT_ABSOLUTE, "Tilt, Absolute"),
)

_UP_TO_30: tuple[float, ...] = (30, 24, 20, 15, 10, 7.5, 5)
FORMATS: Mapping[PixelFormat, Mapping[Size, tuple[float, ...]]] = {
    PixelFormat.YUYV: {(640, 480): _UP_TO_30, (1280, 720): (10, 7.5, 5), (1920, 1080): (5,)},
    PixelFormat.MJPEG: {
        (640, 480): _UP_TO_30,
        (1280, 720): (60, 50, *_UP_TO_30),
        (1920, 1080): _UP_TO_30,
    },
}
NAMES = {PixelFormat.YUYV: "YUYV 4:2:2", PixelFormat.MJPEG: "Motion-JPEG"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class CameraDescription:
    """One camera: its names, its place on the bus, and all that it offers."""

    card: str = "C922 Pro Stream Webcam"
    vendor: str = "046d"
    usb_port: str = "1"
    formats: Mapping[PixelFormat, Mapping[Size, tuple[float, ...]]] = dataclasses.field(
        default_factory=lambda: FORMATS
    )
    controls: tuple[ControlDescription, ...] = CONTROLS

    @property
    def serial(self) -> str:
        """The camera's own number; another camera sits in each port."""
        return f"5B0C2E{self.usb_port:0>2}"

    @property
    def bus(self) -> str:
        """Where it is plugged in, as the driver says it."""
        return f"usb-0000:00:14.0-{self.usb_port}"

    @property
    def links(self) -> tuple[str, str]:
        """How udev's names for it in /dev/v4l begin: by the port, and by the camera's own number."""
        return (
            f"by-path/pci-0000:00:14.0-usb-0:{self.usb_port}:1.0",
            f"by-id/usb-{self.vendor}_{self.card.replace(' ', '_')}_{self.serial}",
        )
