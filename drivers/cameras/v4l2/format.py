"""Ask a camera for JPEG pictures of one size at one rate. Drivers grant what comes nearest; here nothing else will do."""

from linuxpy.video.device import PixelFormat, VideoCapture
from linuxpy.video.raw import v4l2_fract

from drivers.cameras.errors import CameraFormatError
from drivers.cameras.v4l2.listing import picture_formats
from drivers.cameras.v4l2.settings import V4l2CameraSettings

JPEG = PixelFormat.MJPEG.human_str()
RATE_TOLERANCE = 0.01


def set_format(capture: VideoCapture, settings: V4l2CameraSettings) -> None:
    """Raises CameraFormatError naming what was asked, what the camera grants and what it offers."""
    pixels = capture.set_format(settings.width_px, settings.height_px, JPEG).fmt.pix
    if pixels.pixelformat != PixelFormat.MJPEG:
        formats = sorted({offered.pixel_format for offered in picture_formats(capture.device)})
        raise CameraFormatError(f"it gives no JPEG pictures ({JPEG}), only {', '.join(formats)}")
    offered = [offer for offer in picture_formats(capture.device) if offer.pixel_format == JPEG]
    asked = (settings.width_px, settings.height_px)
    if (pixels.width, pixels.height) != asked:
        raise CameraFormatError(
            f"asked for {asked[0]}x{asked[1]} px, it grants {pixels.width}x{pixels.height}; "
            f"it offers {', '.join(f'{offer.width_px}x{offer.height_px}' for offer in offered)}"
        )
    granted_hz = _rate_hz(capture.set_fps(settings.rate_hz).parm.capture.timeperframe)
    if not same_rate(granted_hz, settings.rate_hz):
        rates = [
            rate for offer in offered if (offer.width_px, offer.height_px) == asked for rate in offer.rates_hz
        ]
        raise CameraFormatError(
            f"asked for {settings.rate_hz:g} Hz, it grants {granted_hz:g}; "
            f"at {asked[0]}x{asked[1]} px it offers {', '.join(f'{rate:g}' for rate in rates)} Hz"
        )


def same_rate(one_hz: float, other_hz: float) -> bool:
    """29.97 Hz is called 30 Hz."""
    return abs(one_hz - other_hz) <= RATE_TOLERANCE * other_hz


def _rate_hz(interval: v4l2_fract) -> float:
    """Zero from a driver that does not say."""
    return float(interval.denominator / interval.numerator) if interval.numerator else 0.0
