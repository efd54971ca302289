"""The picture formats of one camera: the ioctls that list them and choose one."""

import errno
import fractions
import os
from typing import TypeVar

from linuxpy.video import raw

from drivers.simulated.v4l2.description import NAMES, CameraDescription, Size

Entry = TypeVar("Entry")

JPEG_BYTES_PER_PIXEL = 2
"""uvcvideo's room for a compressed picture, at most."""


class Formats:
    """`granted` is a size that the camera takes whatever is asked."""

    def __init__(self, description: CameraDescription) -> None:
        self._formats = description.formats
        self.pixel_format = next(iter(self._formats))
        self.size: Size = next(iter(self._formats[self.pixel_format]))
        self.rate_hz = max(self._formats[self.pixel_format][self.size])
        self.granted: Size | None = None

    @property
    def bytes_at_most(self) -> int:
        """Of one picture."""
        width, height = self.size
        return width * height * JPEG_BYTES_PER_PIXEL

    def describe(self, asked: raw.v4l2_fmtdesc) -> None:
        """VIDIOC_ENUM_FMT."""
        pixel_format = _at(list(self._formats), asked.index)
        asked.pixelformat, asked.description = pixel_format, NAMES[pixel_format].encode()
        asked.flags = raw.ImageFormatFlag.COMPRESSED if pixel_format == raw.PixelFormat.MJPEG else 0

    def describe_size(self, asked: raw.v4l2_frmsizeenum) -> None:
        """VIDIOC_ENUM_FRAMESIZES."""
        asked.type = raw.Frmsizetypes.DISCRETE
        asked.discrete.width, asked.discrete.height = _at(
            list(self._formats.get(asked.pixel_format, ())), asked.index
        )

    def describe_rate(self, asked: raw.v4l2_frmivalenum) -> None:
        """VIDIOC_ENUM_FRAMEINTERVALS."""
        rates = self._formats.get(asked.pixel_format, {}).get((asked.width, asked.height), ())
        asked.type = raw.Frmivaltypes.DISCRETE
        _put_interval(asked.discrete, _at(list(rates), asked.index))

    def get(self, asked: raw.v4l2_format) -> None:
        """VIDIOC_G_FMT."""
        pixels = asked.fmt.pix
        pixels.width, pixels.height = self.size
        pixels.pixelformat, pixels.field = self.pixel_format, raw.Field.NONE
        pixels.sizeimage = self.bytes_at_most

    def set(self, asked: raw.v4l2_format) -> None:
        """VIDIOC_S_FMT: what comes nearest."""
        pixels = asked.fmt.pix
        if pixels.pixelformat in self._formats:
            self.pixel_format = raw.PixelFormat(pixels.pixelformat)
        width, height = pixels.width, pixels.height
        nearest = min(
            self._formats[self.pixel_format], key=lambda size: abs(size[0] - width) + abs(size[1] - height)
        )
        self.size = self.granted or nearest
        self.rate_hz = max(self._rates())
        self.get(asked)

    def get_rate(self, asked: raw.v4l2_streamparm) -> None:
        """VIDIOC_G_PARM."""
        _put_interval(asked.parm.capture.timeperframe, self.rate_hz)

    def set_rate(self, asked: raw.v4l2_streamparm) -> None:
        """VIDIOC_S_PARM: what comes nearest."""
        interval = asked.parm.capture.timeperframe
        wanted_hz = interval.denominator / interval.numerator
        self.rate_hz = min(self._rates(), key=lambda rate_hz: abs(rate_hz - wanted_hz))
        self.get_rate(asked)

    def _rates(self) -> tuple[float, ...]:
        return self._formats[self.pixel_format].get(self.size, (self.rate_hz,))


def _at(entries: list[Entry], index: int) -> Entry:
    if index >= len(entries):
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))
    return entries[index]


def _put_interval(interval: raw.v4l2_fract, rate_hz: float) -> None:
    rate = fractions.Fraction(rate_hz)
    interval.numerator, interval.denominator = rate.denominator, rate.numerator
