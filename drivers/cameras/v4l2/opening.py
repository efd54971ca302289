"""Open a device file; what stands in the way is said in words."""

import contextlib
import errno
import logging
from collections.abc import Iterator
from pathlib import Path

from linuxpy.video.device import Capability, Device, V4L2Error

from drivers.cameras.errors import CameraBusyError, CameraDeviceError
from drivers.cameras.v4l2.device_files import first_name, picture_devices

PROCESSES = Path("/proc")

# it tells of every step at the level at which our processes tell of events
logging.getLogger("linuxpy").setLevel(logging.WARNING)


def open_device(device: str) -> Device:
    """The device, open; raises CameraDeviceError when it is missing, forbidden, or gives no pictures."""
    opened = Device(device)
    with device_errors(device), contextlib.ExitStack() as failing:
        failing.callback(opened.close)
        try:
            opened.open()
        except FileNotFoundError as error:
            raise CameraDeviceError(f"{device} is not there; {_present()}") from error
        except PermissionError as error:
            raise CameraDeviceError(
                f"{device} may not be opened by this user; members of the group `video` may: "
                "sudo usermod -aG video $USER, then log in anew"
            ) from error
        if Capability.VIDEO_CAPTURE not in opened.info.device_capabilities:
            raise CameraDeviceError(f"{device} ({opened.info.card}) gives no pictures; {_present()}")
        failing.pop_all()
    return opened


@contextlib.contextmanager
def device_errors(device: str) -> Iterator[None]:
    """Say what the kernel or linuxpy refuses; raises CameraDeviceError, CameraBusyError when another program has the camera."""
    try:
        yield
    except OSError as error:
        if error.errno == errno.EBUSY:
            raise CameraBusyError(f"{device} is in use {_by_whom(device)}") from error
        if error.errno == errno.ENOSPC:
            raise CameraDeviceError(
                f"{device}: its USB bus has no room left for these pictures; plug each camera into a controller of its own"
            ) from error
        raise CameraDeviceError(f"{device}: {error.strerror or error}") from error
    except (V4L2Error, ValueError, RuntimeWarning) as error:
        # linuxpy's words for an answer of the driver that it makes no sense of
        raise CameraDeviceError(f"{device}: its driver answers with what makes no sense: {error}") from error


def _present() -> str:
    present = ", ".join(str(first_name(path)) for path in picture_devices())
    return f"there are {present}" if present else "no camera is there at all"


def _by_whom(device: str) -> str:
    """The programs that have the device file open, as far as this user may see."""
    node = Path(device).resolve()
    holders = sorted({_program(link) for link in PROCESSES.glob("[0-9]*/fd/*") if _leads_to(link, node)})
    return f"by {', '.join(holders)}" if holders else f"by another user's program: sudo fuser -v {node}"


def _leads_to(link: Path, node: Path) -> bool:
    # processes and their files come and go while they are looked at
    with contextlib.suppress(OSError):
        return link.readlink() == node
    return False


def _program(link: Path) -> str:
    process = link.parents[1]
    with contextlib.suppress(OSError):
        return f"{(process / 'comm').read_text().strip()} (process {process.name})"
    return f"process {process.name}"
