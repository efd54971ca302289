"""One webcam behind a device file: its ioctls, its clock, and all that can go wrong with it."""

import errno
import itertools
import mmap
import os
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from linuxpy.video import raw

from drivers.simulated.v4l2.controls import Controls
from drivers.simulated.v4l2.description import CameraDescription
from drivers.simulated.v4l2.device_files import DeviceFiles
from drivers.simulated.v4l2.exposing import Buffers
from drivers.simulated.v4l2.formats import Formats
from drivers.simulated.v4l2.scene import Scene

CAPABILITIES = raw.Capability.VIDEO_CAPTURE | raw.Capability.STREAMING | raw.Capability.EXT_PIX_FORMAT
KERNEL_VERSION = 6 << 16 | 1 << 8


class StandInCamera:
    """A camera that takes `pictures` (coded JPEGs in turn, or a scene by its controls), by its own clock while it streams if it
    is `running`, otherwise whenever `expose` is called.

    It is reached through `path` while `plugged_in` holds, and may be pulled out and put back meanwhile.
    """

    def __init__(
        self,
        pictures: Sequence[bytes] | Scene,
        description: CameraDescription | None = None,
        *,
        running: bool = True,
    ) -> None:
        self.description = description or CameraDescription()
        self.controls = Controls(self.description.controls)
        self.formats = Formats(self.description)
        self.buffers = Buffers(
            pictures.seen(self.controls.values) if isinstance(pictures, Scene) else itertools.cycle(pictures)
        )
        self.files: DeviceFiles | None = None
        self.is_permitted = True
        self.start_refused = 0
        """The error number that it answers with when a stream is to start; none for zero."""
        self.starts = 0
        """How often a stream was started."""
        self._opened: set[int] = set()
        self._hung: str | None = None
        self._is_running = running
        self._owner: int | None = None
        self._lock = threading.RLock()
        self._answers: dict[int, Callable[[Any], None]] = {
            raw.IOC.QUERYCAP: self._say_capabilities,
            raw.IOC.ENUM_FMT: self.formats.describe,
            raw.IOC.ENUM_FRAMESIZES: self.formats.describe_size,
            raw.IOC.ENUM_FRAMEINTERVALS: self.formats.describe_rate,
            raw.IOC.G_FMT: self.formats.get,
            raw.IOC.G_PARM: self.formats.get_rate,
            raw.IOC.QUERY_EXT_CTRL: self.controls.query,
            raw.IOC.QUERYMENU: self.controls.menu,
            raw.IOC.G_EXT_CTRLS: self.controls.get,
            raw.IOC.S_EXT_CTRLS: self.controls.set,
        }
        self._answers_to_owner: dict[int, Callable[[Any], None]] = {
            raw.IOC.S_FMT: self.formats.set,
            raw.IOC.S_PARM: self.formats.set_rate,
            raw.IOC.REQBUFS: self._request_buffers,
            raw.IOC.QUERYBUF: self._query_buffer,
            raw.IOC.QBUF: self._queue_buffer,
            raw.IOC.DQBUF: self._fetch_buffer,
            raw.IOC.STREAMON: self._start,
            raw.IOC.STREAMOFF: lambda _: self.buffers.stop(),
        }

    @property
    def path(self) -> Path:
        """The lasting name of its device file."""
        return self._plugged().lasting

    def expose(
        self,
        picture: bytes | None = None,
        *,
        flags: int = 0,
        timestamp_ns: int | None = None,
        lost_before: int = 0,
    ) -> None:
        """Take one picture now: the next one unless another is given, after `lost_before` that did not arrive."""
        with self._lock:
            self.buffers.lose(lost_before)
            picture = self.buffers.next_picture() if picture is None else picture
            self.buffers.fill(picture, flags, timestamp_ns)

    def hang(self, *, repeating: bool = False) -> None:
        """Give no pictures any more, or the same one for ever, until a stream is started again."""
        with self._lock:
            self._hung = "repeating" if repeating else "silent"
            self._last = self.buffers.next_picture()

    def plug_in(self) -> None:
        """Connected, with its controls as they are from the factory."""
        with self._lock:
            self.buffers.renew()
            self.controls.reset()
            self._owner = None
            self._plugged().create()

    def pull_out(self) -> None:
        """It loses its connection in the middle of a picture: half of it can still be fetched, and nothing more."""
        with self._lock:
            picture = self.buffers.next_picture()
            self.buffers.fill(picture[: len(picture) // 2], raw.BufferFlag.ERROR)
            self._opened.clear()
            self.buffers.break_off()
            self._plugged().remove()

    def opened(self) -> int:
        """A program opens it: a file descriptor of its own."""
        with self._lock:
            file = os.dup(self.buffers.readable)
            self._opened.add(file)
            return file

    def ioctl(self, file: int, request: int, argument: Any) -> None:
        """Answer what the program that has this file open asks; raises OSError as the kernel would."""
        with self._lock:
            is_fetching = request == raw.IOC.DQBUF and self.buffers.is_waiting
            if file not in self._opened and not is_fetching:
                raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
            answer = self._answers.get(request)
            if answer is None:
                answer = self._answers_to_owner.get(request)
                if answer is None:
                    raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
                if self._owner not in {None, file}:
                    raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
                if request == raw.IOC.REQBUFS:
                    self._owner = file if argument.count else None
            answer(argument)

    def closed(self, file: int) -> None:
        """The program has closed this file."""
        with self._lock:
            self._opened.discard(file)
            if self._owner == file:
                self._owner = None
                self.buffers.request(0, 0)

    def _plugged(self) -> DeviceFiles:
        if self.files is None:
            raise RuntimeError("the camera has no place to be plugged into; see plugged_in")
        return self.files

    def _say_capabilities(self, asked: raw.v4l2_capability) -> None:
        asked.driver, asked.card = b"uvcvideo", self.description.card.encode()
        asked.bus_info, asked.version = self.description.bus.encode(), KERNEL_VERSION
        asked.capabilities = CAPABILITIES | raw.Capability.META_CAPTURE | raw.Capability.DEVICE_CAPS
        asked.device_caps = CAPABILITIES

    def _request_buffers(self, asked: raw.v4l2_requestbuffers) -> None:
        self.buffers.request(asked.count, self.formats.bytes_at_most)

    def _query_buffer(self, asked: raw.v4l2_buffer) -> None:
        asked.length, asked.m.offset = self.formats.bytes_at_most, asked.index * mmap.PAGESIZE
        asked.flags = raw.BufferFlag.MAPPED | self.buffers.flags

    def _queue_buffer(self, asked: raw.v4l2_buffer) -> None:
        self.buffers.queue(asked.index)

    def _fetch_buffer(self, asked: raw.v4l2_buffer) -> None:
        filled = self.buffers.fetch()
        asked.index, asked.bytesused, asked.flags = filled.index, filled.length, filled.flags
        asked.length, asked.sequence, asked.field = (
            self.formats.bytes_at_most,
            filled.sequence,
            raw.Field.NONE,
        )
        asked.timestamp.secs, asked.timestamp.usecs = divmod(filled.timestamp_us, 1_000_000)

    def _start(self, _: Any) -> None:
        if self.start_refused:
            raise OSError(self.start_refused, os.strerror(self.start_refused))
        self.buffers.start()
        self._hung = None
        self.starts += 1
        if self._is_running:
            threading.Thread(target=self._run, args=(self.starts,), daemon=True).start()

    def _run(self, start: int) -> None:
        """Expose by the clock for as long as this stream lasts."""
        due_s = time.monotonic()
        while True:
            due_s += 1 / self.formats.rate_hz
            time.sleep(max(0.0, due_s - time.monotonic()))
            with self._lock:
                if start != self.starts or not self.buffers.streaming:
                    return
                if self._hung != "silent":
                    self.expose(self._last if self._hung == "repeating" else None)
