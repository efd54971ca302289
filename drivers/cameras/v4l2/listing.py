"""The cameras that are plugged in, and what they can do."""

import contextlib
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from linuxpy.video.device import BaseMonoControl, BufferType, Device, FrameSizeType, MenuControl

from drivers.cameras.errors import CameraDeviceError
from drivers.cameras.v4l2.controls import SETTINGS, setting_of
from drivers.cameras.v4l2.device_files import first_name, lasting_names, picture_devices
from drivers.cameras.v4l2.opening import device_errors, open_device


@dataclasses.dataclass(frozen=True, kw_only=True)
class PictureFormat:
    """One picture size in one format (a four-character code such as MJPG), and the rates it comes at, fastest first."""

    pixel_format: str
    width_px: int
    height_px: int
    rates_hz: tuple[float, ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class DeviceControl:
    """One control in the camera's own numbers, named as `v4l2-ctl` does; `setting` is its key in [cameras.NAME.controls]."""

    name: str
    setting: str | None
    minimum: int
    maximum: int
    step: int
    default: int
    value: int
    menu: Mapping[int, str]

    def in_setting(self, number: int) -> float:
        """A number of the camera's in the unit of `setting`, as a bench file says it."""
        return SETTINGS[self.setting].value(number) if self.setting else number


@dataclasses.dataclass(frozen=True, kw_only=True)
class DeviceDescription:
    """One camera. `path` is what a bench file should say; `problem`, if any, is why the camera cannot be asked more."""

    path: Path
    lasting_paths: tuple[Path, ...]
    node: Path
    card: str = ""
    driver: str = ""
    bus: str = ""
    formats: tuple[PictureFormat, ...] = ()
    controls: tuple[DeviceControl, ...] = ()
    problem: str = ""


def devices() -> tuple[DeviceDescription, ...]:
    """All that give pictures, in the order of their numbers, and those that cannot be asked, with their problem."""
    return tuple(map(_described, picture_devices()))


def _described(node: Path) -> DeviceDescription:
    path, lasting = first_name(node), tuple(lasting_names(node))
    try:
        with device_errors(str(path)), contextlib.closing(open_device(str(path))) as device:
            return DeviceDescription(
                path=path,
                lasting_paths=lasting,
                node=node,
                card=device.info.card,
                driver=device.info.driver,
                bus=device.info.bus_info,
                formats=picture_formats(device),
                controls=_controls(device),
            )
    except CameraDeviceError as error:
        return DeviceDescription(path=path, lasting_paths=lasting, node=node, problem=str(error))


def picture_formats(device: Device) -> tuple[PictureFormat, ...]:
    """Every size in every format that an open device lists one by one."""
    return tuple(
        PictureFormat(
            pixel_format=image_format.pixel_format.human_str(),
            width_px=size.info.width,
            height_px=size.info.height,
            rates_hz=_rates_hz(device, image_format.pixel_format, size.info.width, size.info.height),
        )
        for image_format in device.info.buffer_formats(BufferType.VIDEO_CAPTURE)
        for size in device.info.format_frame_sizes(image_format.pixel_format)
        if size.type == FrameSizeType.DISCRETE
    )


def _rates_hz(device: Device, pixel_format: int, width: int, height: int) -> tuple[float, ...]:
    intervals = device.info.fps_intervals(pixel_format, width, height)
    return tuple(sorted({float(interval.max_fps) for interval in intervals}, reverse=True))


def _controls(device: Device) -> tuple[DeviceControl, ...]:
    return tuple(
        DeviceControl(
            name=control.config_name,
            setting=setting_of(control.id),
            minimum=control.minimum,
            maximum=control.maximum,
            step=control.step,
            default=int(control.default),
            value=int(control.value),
            menu=dict(control) if isinstance(control, MenuControl) else {},
        )
        for control in device.controls.values()
        if isinstance(control, BaseMonoControl) and not control.is_flagged_write_only
    )
