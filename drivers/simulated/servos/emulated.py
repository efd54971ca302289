"""Emulated servos with their serial device in front and a mechanics simulation behind."""

import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.servos.bus import Answer, ServoBus
from drivers.simulated.servos.errors import EmulatedServosError, ServoStepError
from drivers.simulated.servos.pty import PtySerial
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults


class EmulatedServos:
    """n servos in the order of `settings.ids`. Clients talk to them at `settings.link`; somebody else calls `step`.

    Between two steps the servos stand still and go on answering. Every method may be called from any thread.
    """

    def __init__(self, settings: EmulatedServosSettings, clock: Callable[[], float] = time.monotonic) -> None:
        """Servos just powered on, torque off; `open` makes their device."""
        self._bus = ServoBus(settings)
        self._clock = clock
        self._lock = threading.Lock()
        self._pty = PtySerial(settings.link, self._receive)
        self._link = settings.link
        self._unplugged = False

    def open(self) -> None:
        """Make the device; raises LinkError."""
        self._pty.open()

    def close(self) -> None:
        """Take the device away."""
        self._pty.close()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    @property
    def count(self) -> int:
        """How many servos there are."""
        return len(self._bus.servos)

    @property
    def torque_enabled(self) -> tuple[bool, ...]:
        """Which servos (n) drive their motors."""
        with self._lock:
            return tuple(servo.torque_enabled for servo in self._bus.servos)

    def stand_at(self, number: int, place_rad: float) -> None:
        """The servo in this place of `settings.ids` powers on with its horn here."""
        with self._lock:
            self._bus.servos[number].stand_at(place_rad)

    def step(self, dt_s: float, load_torque_Nm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move on by `dt_s` under loads (n,), and return the horns' angles in rad (n,), counted from power-on over turns.

        A positive load pulls its horn towards smaller angles. Raises ServoStepError on loads or times that cannot be,
        EmulatedServosError when the device is served no more.
        """
        count = self.count
        if np.shape(load_torque_Nm) != (count,) or not np.isfinite(load_torque_Nm).all() or not 0 < dt_s <= 1:
            raise ServoStepError(
                f"a step of {dt_s} s with loads {load_torque_Nm} Nm: needed are {count} finite loads and 0 to 1 s"
            )
        if not (self._pty.is_serving or self._unplugged):
            raise EmulatedServosError(
                f"nobody serves the emulated servos at {self._link}: not opened, or failed"
            )
        with self._lock:
            self._bus.step(dt_s, [float(load) for load in load_torque_Nm], self._clock())
            return np.array([servo.motor.position_rad for servo in self._bus.servos])

    def set_faults(self, faults: Faults) -> None:
        """Spoil answers from here on, counting them from 1."""
        with self._lock:
            self._bus.set_faults(faults)

    def fail(self, servo_id: int, error_bits: int) -> None:
        """Let a servo show a hardware error (bits as in its Hardware Error Status) until it is rebooted."""
        with self._lock:
            self._bus.servo(servo_id).fail(error_bits)

    def restart(self, servo_id: int) -> None:
        """Let a servo restart by itself, as after a dip of its supply."""
        with self._lock:
            self._bus.servo(servo_id).reboot(self._clock())

    def set_registers(self, servo_id: int, **values: int) -> None:
        """Have a servo's registers hold other values, past all rules: `id=12` gives two servos one id."""
        with self._lock:
            memory = self._bus.servo(servo_id).memory
            for name, value in values.items():
                memory[name] = value

    def registers(self, servo_id: int, *names: str) -> tuple[int, ...]:
        """What stands in a servo's registers."""
        with self._lock:
            return tuple(self._bus.servo(servo_id).memory[name] for name in names)

    def unplug(self) -> None:
        """Take the serial device away; the servos keep their supply and go on as they are."""
        self._pty.close()
        self._unplugged = True

    def plug_in(self) -> None:
        """Bring the serial device back, as another one at the same link; raises LinkError."""
        self._pty.open()
        self._unplugged = False

    def _receive(self, data: bytes, baud_rate: int) -> list[Answer]:
        with self._lock:
            return self._bus.receive(data, self._clock(), baud_rate)
