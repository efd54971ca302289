"""The files that Linux shows cameras as: `/dev/videoN`, and names in `/dev/v4l` that stay the same."""

import contextlib
from pathlib import Path

from linuxpy.device import device_number
from linuxpy.io import IO
from linuxpy.video.device import Capability, read_capabilities

DEVICES = Path("/dev")
LASTING = ("by-path", "by-id")
"""By the port that a camera is plugged into; by its maker, model and serial number, which some cameras lack."""


def picture_devices() -> list[Path]:
    """The video devices that give pictures, by number, and those that cannot be asked: a camera has others besides."""
    return [
        path
        for path in sorted(DEVICES.glob("video*"), key=lambda path: device_number(path) or 0)
        if _gives_pictures(path)
    ]


def lasting_names(device: Path) -> list[Path]:
    """The names of this device that stay the same over restarts, the one by its port first."""
    links = (link for kind in LASTING for link in sorted((DEVICES / "v4l" / kind).glob("*")))
    return [link for link in links if link.resolve() == device.resolve()]


def first_name(device: Path) -> Path:
    """The lasting name by its port if there is one, failing that its own."""
    return next(iter(lasting_names(device)), device)


def _gives_pictures(device: Path) -> bool:
    with contextlib.suppress(OSError), IO.open(device) as opened:
        return Capability.VIDEO_CAPTURE in Capability(read_capabilities(opened).device_caps)
    return True
