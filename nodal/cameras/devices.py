"""Devices that are plugged in, and how to set one up."""

from pathlib import Path

import msgspec

from drivers.cameras import V4l2CameraSettings, V4l2Controls
from drivers.cameras.errors import CameraDeviceError
from drivers.cameras.v4l2.format import JPEG, same_rate
from drivers.cameras.v4l2.listing import DeviceDescription, PictureFormat, devices
from nodal.cameras.judging.suggestions import FRAME_SHARE, Held

WIDEST_PX, HIGHEST_PX = 1920, 1080
"""Larger pictures cost more than they tell (docs/bench-setup.md)."""
RATE_HZ = 30.0
KEPT = ("gain", "focus", "white_balance_k", "sharpness", "zoom", "pan", "tilt")
"""Controls that are locked at what the camera holds now."""

NO_CAMERA = (
    "no camera is plugged in: there is no /dev/video* that gives pictures. `lsusb` shows whether the computer sees it at all; a "
    "container or a virtual machine needs the device handed through; `sudo modprobe uvcvideo` loads the driver of webcams"
)


def device_at(path: str) -> DeviceDescription:
    """The device that this path leads to; raises CameraDeviceError when it is not there or cannot be asked."""
    present = devices()
    for device in present:
        if Path(path).resolve() == device.node.resolve():
            if device.problem:
                raise CameraDeviceError(device.problem)
            return device
    there = ", ".join(str(device.path) for device in present)
    raise CameraDeviceError(f"{path} is no camera; {f'there are {there}' if there else NO_CAMERA}")


def held_controls(path: str) -> dict[str, Held]:
    """What a device holds now, by the keys of [cameras.NAME.controls]; raises CameraDeviceError."""
    return {
        control.setting: Held(
            value=control.in_setting(control.value),
            least=control.in_setting(control.minimum),
            default=control.in_setting(control.default),
        )
        for control in device_at(path).controls
        if control.setting is not None
    }


def suggested_settings(device: DeviceDescription, mains_hz: int = 50) -> V4l2CameraSettings:
    """A bench's settings of this camera: JPEG pictures of up to 1080p, near 30 Hz, exposed for one half period of the mains,
    everything else as it is now. Raises CameraDeviceError for a camera that gives no JPEG pictures.
    """
    of_jpeg = [known for known in device.formats if known.pixel_format == JPEG and known.rates_hz]
    if not of_jpeg:
        kinds = ", ".join(sorted({known.pixel_format for known in device.formats})) or "none"
        raise CameraDeviceError(f"{device.path} ({device.card}) gives no JPEG pictures; its formats: {kinds}")
    best = max(of_jpeg, key=_worth)
    present = {control.setting: control for control in device.controls if control.setting is not None}
    controls: dict[str, float] = {
        key: present[key].in_setting(present[key].value) for key in KEPT if key in present
    }
    if (exposure := present.get("exposure_s")) is not None:
        least, most = (exposure.in_setting(number) for number in (exposure.minimum, exposure.maximum))
        longest = min(most, FRAME_SHARE / _rate_hz(best))
        controls["exposure_s"] = round(max(min(0.5 / mains_hz, longest), least), 4)
    if "power_line_hz" in present:
        controls["power_line_hz"] = mains_hz
    return V4l2CameraSettings(
        device=str(device.path),
        width_px=best.width_px,
        height_px=best.height_px,
        rate_hz=_rate_hz(best),
        controls=msgspec.convert(controls, V4l2Controls),
    )


def _rate_hz(known: PictureFormat) -> float:
    """The rate nearest to what sensing follows."""
    return min(known.rates_hz, key=lambda rate_hz: abs(rate_hz - RATE_HZ))


def _worth(known: PictureFormat) -> tuple[bool, int]:
    """What is fast enough, then the largest that fits, failing that the smallest that does not."""
    fits = known.width_px <= WIDEST_PX and known.height_px <= HIGHEST_PX
    area_px = known.width_px * known.height_px
    fast = max(known.rates_hz) >= RATE_HZ or same_rate(max(known.rates_hz), RATE_HZ)
    return fast, area_px if fits else -area_px
