"""The edge to PyAV: pictures at their times into an H.264 film."""

from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from messaging.errors import NodalError
from nodal.errors import ExportError

TICK = Fraction(1, 90_000)
OPTIONS = {"crf": "20", "preset": "veryfast"}
NOMINAL_RATE_HZ = 30


class Encoder:
    """Writes an MP4 file; used in a `with` statement. Raises NodalError without PyAV, ExportError when it cannot write."""

    def __init__(self, path: Path, width_px: int, height_px: int) -> None:
        """Both sizes are even."""
        try:
            import av  # noqa: PLC0415  slow, and part of an extra
        except ImportError as error:
            raise NodalError("MP4 needs PyAV; install nodal with its extra `export`") from error
        self._av = av
        self._path = path
        self._first_ns: int | None = None
        self._last_tick = -1
        self.pictures = 0
        try:
            self._file = av.open(str(path), "w", format="mp4", options={"movflags": "faststart"})
        except av.FFmpegError as error:
            raise ExportError(f"{path}: cannot be written: {error}") from error
        self._stream = self._file.add_stream("libx264", rate=NOMINAL_RATE_HZ, options=OPTIONS)
        self._stream.width, self._stream.height, self._stream.pix_fmt = width_px, height_px, "yuv420p"
        self._stream.codec_context.time_base = TICK

    def add(self, picture: NDArray[np.uint8], time_ns: int) -> None:
        """A picture (height, width, 3) in BGR, shown from this time on; one that is not later than the last is left out."""
        if self._first_ns is None:
            self._first_ns = time_ns
        tick = round(Fraction(time_ns - self._first_ns, 10**9) / TICK)
        if tick <= self._last_tick:
            return
        self._last_tick = tick
        frame = self._av.VideoFrame.from_ndarray(picture, format="bgr24")
        frame.pts, frame.time_base = tick, TICK
        self._encode(frame)
        self.pictures += 1

    @property
    def duration_s(self) -> float:
        """From the first picture to the last."""
        return max(float(self._last_tick * TICK), 0.0)

    def __enter__(self) -> Self:
        """Ready for pictures."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the film, unless there is none."""
        if error is None:
            self._encode(None)
        self._file.close()

    def _encode(self, frame: Any) -> None:
        try:
            self._file.mux(self._stream.encode(frame))
        except self._av.FFmpegError as error:
            raise ExportError(f"{self._path}: cannot be written: {error}") from error
