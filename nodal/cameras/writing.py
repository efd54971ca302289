"""Which device is which camera of a bench, and what a bench file should say of it."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from drivers.cameras.v4l2.listing import DeviceDescription, devices
from nodal.cameras.devices import NO_CAMERA, device_at, suggested_settings
from nodal.errors import CommandError
from nodal.toml_file import Table

NAME = re.compile(r"[A-Za-z0-9_-]+")


def assigned(given: Sequence[str], names: Sequence[str]) -> dict[str, DeviceDescription]:
    """The device of each camera: as `given` (NAME=DEVICE), else the bench's cameras in the order of the devices.

    Raises CommandError where that is not clear, CameraDeviceError for a device that is not there.
    """
    if given:
        return _as_given(given)
    present = devices()
    if not present:
        raise CommandError(NO_CAMERA)
    if len(present) != len(names):
        raise CommandError(
            f"{len(present)} cameras are plugged in ({', '.join(str(device.path) for device in present)}), the bench has "
            f"{len(names)} ({', '.join(names)}); say which is which: --camera NAME=DEVICE ..."
        )
    return {name: device_at(str(device.path)) for name, device in zip(names, present, strict=True)}


def _as_given(given: Sequence[str]) -> dict[str, DeviceDescription]:
    found: dict[str, DeviceDescription] = {}
    for text in given:
        name, _, path = text.partition("=")
        if not (NAME.fullmatch(name) and path):
            raise CommandError(f"--camera {text}: allowed is NAME=DEVICE, NAME of letters, digits, _ and -")
        device = device_at(path)
        if name in found:
            raise CommandError(f"--camera: {name} is given twice")
        if other := next((other for other, taken in found.items() if taken.node == device.node), None):
            raise CommandError(f"--camera {text}: {device.path} is {other} already")
        found[name] = device
    return found


def replacing(old: Table, new: Table) -> Table:
    """The changes to a table of a bench file that leave nothing of the `old` one in the `new` one."""
    changes = {
        key: replacing(old[key], value) if key in old and isinstance(value, dict) else value
        for key, value in new.items()
    }
    return dict.fromkeys(old.keys() - new.keys()) | changes


def sections(cameras: Mapping[str, DeviceDescription], mains_hz: int) -> dict[str, dict[str, Any]]:
    """[cameras.NAME] of each; raises CameraDeviceError for one that a bench cannot use."""
    tables = {
        name: msgspec.to_builtins(suggested_settings(device, mains_hz)) for name, device in cameras.items()
    }
    for table in tables.values():
        table["controls"] = {key: value for key, value in table["controls"].items() if value is not None}
    return tables
