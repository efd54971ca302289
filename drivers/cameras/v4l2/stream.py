"""One opening of one camera, from its device file to the pictures that it streams."""

import contextlib
import dataclasses
import time
from collections.abc import Mapping
from types import MappingProxyType

from linuxpy.video.device import BufferFlag, Frame, VideoCapture

from drivers.cameras.errors import CameraFormatError
from drivers.cameras.v4l2.controls import in_settings, locked_controls
from drivers.cameras.v4l2.format import set_format
from drivers.cameras.v4l2.opening import device_errors, open_device
from drivers.cameras.v4l2.settings import V4l2CameraSettings

BUFFERS = 4
NS_PER_S = 1_000_000_000
NS_PER_US = 1_000
OTHER_CLOCK = "its driver does not stamp pictures by the monotonic clock"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Captured:
    """A picture as the kernel hands it over. `sequence` counts from the stream's start, pictures lost on the way included."""

    jpeg: bytes
    capture_monotonic_ns: int
    sequence: int
    is_damaged: bool


class Stream:
    """A camera that streams with everything locked. Pictures begun before that are left out."""

    def __init__(
        self, settings: V4l2CameraSettings, before: Mapping[int, int] = MappingProxyType({})
    ) -> None:
        """Controls that the settings do not mention become what they were `before`; raises CameraDeviceError."""
        self._device = settings.device
        self._opened = open_device(settings.device)
        self._capture = VideoCapture(self._opened, size=BUFFERS)
        try:
            with device_errors(settings.device):
                set_format(self._capture, settings)
                self._capture.open()
                self.held = locked_controls(self._opened, settings.controls, before)
                exposure_s = in_settings(self.held).get("exposure_s", 0.0)
                self._middle_ns = _middle_ns(self._capture, exposure_s)
        except BaseException:
            self.close()
            raise
        self._not_before_ns = time.monotonic_ns()
        self.card: str = self._opened.info.card

    def read(self, timeout_s: float) -> Captured | None:
        """The next picture; None if none comes within this time. Raises CameraDeviceError once the camera is gone."""
        with device_errors(self._device):
            frame = self._next(timeout_s)
        if frame is None:
            return None
        stamp, now_ns = frame.buff.timestamp, time.monotonic_ns()
        stamp_ns = stamp.secs * NS_PER_S + stamp.usecs * NS_PER_US
        if stamp_ns > now_ns + NS_PER_S:
            raise CameraFormatError(f"{OTHER_CLOCK}: a picture comes from the future")
        if stamp_ns < self._not_before_ns:
            return None
        self._not_before_ns = 0
        return Captured(
            jpeg=frame.data,
            # drivers stamp later than they say, and nothing is seen after it has arrived
            capture_monotonic_ns=min(stamp_ns + self._middle_ns, now_ns),
            sequence=frame.frame_nb,
            is_damaged=BufferFlag.ERROR in frame.flags,
        )

    def close(self) -> None:
        """Let the device go, whether it is still there or not."""
        with contextlib.suppress(OSError):
            self._capture.stream_off()
        # what is mapped must be let go of too, or the kernel keeps the number of a device that is gone
        if self._capture.buffer is not None:
            with contextlib.suppress(OSError):
                self._capture.disarm()
        self._opened.close()

    def _next(self, timeout_s: float) -> Frame | None:
        # a poll may end without a picture
        with contextlib.suppress(BlockingIOError):
            return self._capture.buffer.frame_reader.read(timeout_s)
        return None


def _middle_ns(capture: VideoCapture, exposure_s: float) -> int:
    """From the kernel's time stamp to the middle of the exposure; raises CameraFormatError if no clock of ours stamps.

    Stamps are of the start of the exposure, or of the end of the picture's arrival ("Buffers", V4L2 user-space API).
    """
    flags = capture.buffers[0].flags
    if flags & BufferFlag.TIMESTAMP_MASK != BufferFlag.TIMESTAMP_MONOTONIC:
        raise CameraFormatError(OTHER_CLOCK)
    half_ns = round(exposure_s * NS_PER_S / 2)
    return half_ns if flags & BufferFlag.TSTAMP_SRC_MASK == BufferFlag.TSTAMP_SRC_SOE else -half_ns
