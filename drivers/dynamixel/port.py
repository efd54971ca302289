"""The serial port: the only file of this driver that touches a device."""

import contextlib
import errno
import os
import select
import termios
import time
from typing import Protocol

import serial

from drivers.dynamixel.errors import PortBusyError, PortError, PortLostError, PortMissingError

READ_SIZE = 4096
BITS_PER_BYTE = 10


class Line(Protocol):
    """What the bus asks of whatever carries its bytes; it keeps the time too, so that a line may live in virtual time."""

    @property
    def path(self) -> str:
        """What errors call it."""
        ...

    @property
    def is_open(self) -> bool:
        """Whether bytes may be sent."""
        ...

    def open(self) -> None:
        """Take it; raises PortError."""
        ...

    def close(self) -> None:
        """Let it go, whatever state it is in."""
        ...

    def send(self, data: bytes) -> None:
        """Drop what was received before and send; raises PortLostError."""
        ...

    def receive(self, deadline_s: float) -> bytes:
        """Some bytes as soon as there are any, or none at `deadline_s`; raises PortLostError."""
        ...

    def transfer_time_s(self, byte_count: int) -> float:
        """How long so many bytes take."""
        ...

    def now_s(self) -> float:
        """The line's clock, which only runs forwards."""
        ...

    def pause(self, seconds: float) -> None:
        """Wait."""
        ...


class SerialPort:
    """A serial port opened for this process alone, that waits in the kernel and never longer than it is told."""

    def __init__(self, path: str, baud_rate: int = 1_000_000) -> None:
        """Remember where; nothing is opened yet."""
        self._path = path
        self._baud_rate = baud_rate
        self._serial: serial.Serial | None = None

    @property
    def path(self) -> str:
        """The device's path."""
        return self._path

    @property
    def is_open(self) -> bool:
        """Whether the device is held."""
        return self._serial is not None

    def open(self) -> None:
        """Take the device; raises PortMissingError, PortBusyError or PortError. Opening an open port does nothing."""
        if self._serial is not None:
            return
        try:
            self._serial = serial.Serial(self.path, self._baud_rate, timeout=0, exclusive=True)
        except (serial.SerialException, termios.error, OSError, ValueError) as error:
            raise self._refusal(error) from error
        with contextlib.suppress(ValueError, NotImplementedError):  # only some adapters have a latency timer
            self._serial.set_low_latency_mode(True)

    def close(self) -> None:
        """Let the device go, whatever state it is in."""
        port, self._serial = self._serial, None
        if port is not None:
            with contextlib.suppress(
                serial.SerialException, OSError
            ):  # an unplugged device cannot be closed politely
                port.close()

    def send(self, data: bytes) -> None:
        """Drop what was received before and send `data`; raises PortLostError, with the port closed."""
        port = self._opened()
        try:
            port.reset_input_buffer()
            sent = os.write(port.fd, data)  # never waits: the device is opened non-blocking
        except (termios.error, OSError) as error:
            raise self._lost(error) from error
        if sent != len(data):
            raise self._lost(BlockingIOError(f"it took {sent} of {len(data)} bytes"))

    def receive(self, deadline_s: float) -> bytes:
        """Some bytes as soon as there are any, or none at `deadline_s` (time.monotonic); raises PortLostError."""
        port = self._opened()
        try:
            ready, _, _ = select.select([port.fd], [], [], max(0.0, deadline_s - time.monotonic()))
            data = os.read(port.fd, READ_SIZE) if ready else b""
        except (OSError, ValueError) as error:
            raise self._lost(error) from error
        if ready and not data:
            raise self._lost(EOFError("it hung up"))
        return data

    def transfer_time_s(self, byte_count: int) -> float:
        """How long `byte_count` bytes take on the wire."""
        return byte_count * BITS_PER_BYTE / self._baud_rate

    def now_s(self) -> float:
        """time.monotonic."""
        return time.monotonic()

    def pause(self, seconds: float) -> None:
        """Sleep."""
        time.sleep(seconds)

    def _opened(self) -> serial.Serial:
        if self._serial is None:
            raise PortLostError(f"serial port {self.path} is not open")
        return self._serial

    def _lost(self, error: Exception) -> PortLostError:
        self.close()
        return PortLostError(
            f"serial port {self.path} was lost ({error}); it is closed and may be opened again"
        )

    def _refusal(self, error: Exception) -> PortError:
        match getattr(error, "errno", None):
            case errno.ENOENT | errno.ENODEV | errno.ENXIO:
                return PortMissingError(f"serial port {self.path} does not exist; is the adapter plugged in?")
            case errno.EBUSY | errno.EAGAIN:
                return PortBusyError(f"serial port {self.path} is in use by another program")
            case errno.EACCES | errno.EPERM:
                return PortError(
                    f"serial port {self.path} may not be opened by this user; is it in group dialout?"
                )
        return PortError(f"serial port {self.path} cannot be used at {self._baud_rate} baud: {error}")
