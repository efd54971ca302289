"""The files that Linux shows cameras as: `/dev/videoN`, and names in `/dev/v4l` that stay the same."""

from pathlib import Path

from linuxpy.device import device_number

DEVICES = Path("/dev")
LASTING = ("by-path", "by-id")
"""By the port that a camera is plugged into; by its maker, model and serial number, which some cameras lack."""


def device_files() -> list[Path]:
    """All video devices by number. A camera may have several, of which only some give pictures."""
    return sorted(DEVICES.glob("video*"), key=lambda path: device_number(path) or 0)


def lasting_names(device: Path) -> list[Path]:
    """The names of this device that stay the same over restarts, the one by its port first."""
    links = (link for kind in LASTING for link in sorted((DEVICES / "v4l" / kind).glob("*")))
    return [link for link in links if link.resolve() == device.resolve()]


def first_name(device: Path) -> Path:
    """The lasting name by its port if there is one, failing that its own."""
    return next(iter(lasting_names(device)), device)
