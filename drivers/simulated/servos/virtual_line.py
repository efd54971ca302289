"""Emulated servos on a line whose time passes only by waiting: conversations of minutes in milliseconds, the same each time."""

from typing import Self

from drivers.simulated.servos.bus import BITS_PER_BYTE, ServoBus
from drivers.simulated.servos.settings import EmulatedServosSettings

BEGIN_S = 100.0


class VirtualLine:
    """What a client of the servos needs of a serial port, without a device: bytes out, bytes back, and a clock."""

    path = "virtual"

    def __init__(self, settings: EmulatedServosSettings) -> None:
        """Servos just powered on; the client speaks at their baud rate."""
        self.servos = ServoBus(settings)
        self.is_open = False
        self.sent = 0
        """How many times something was sent."""
        self._baud_rate = settings.baud_rate
        self._now_s = BEGIN_S
        self._due: list[tuple[float, bytes]] = []

    def speaking_at(self, baud_rate: int) -> Self:
        """The same line, on which the client speaks at another baud rate from now on."""
        self._baud_rate = baud_rate
        return self

    def open(self) -> None:
        """Nothing is in the way."""
        self.is_open = True

    def close(self) -> None:
        """Nothing holds it."""
        self.is_open = False

    def send(self, data: bytes) -> None:
        """Drop what has come before; the servos hear `data` once it is through."""
        self.sent += 1
        arrived_s = self._now_s + self.transfer_time_s(len(data))
        answers = self.servos.receive(data, arrived_s, self._baud_rate)
        self._due = sorted(
            [(at_s, data) for at_s, data in self._due if at_s > self._now_s]
            + [(arrived_s + answer.delay_s, answer.data) for answer in answers]
        )

    def receive(self, deadline_s: float) -> bytes:
        """What comes next, or nothing at `deadline_s`."""
        if self._due and self._due[0][0] <= deadline_s:
            at_s, data = self._due.pop(0)
            self._now_s = max(self._now_s, at_s)
            return data
        self._now_s = max(self._now_s, deadline_s)
        return b""

    def transfer_time_s(self, byte_count: int) -> float:
        """How long so many bytes take."""
        return byte_count * BITS_PER_BYTE / self._baud_rate

    def now_s(self) -> float:
        """The line's time."""
        return self._now_s

    def pause(self, seconds: float) -> None:
        """Wait; the servos stand still."""
        self._now_s += seconds

    def run(self, seconds: float, load_torque_Nm: float = 0.0, step_s: float = 0.01) -> None:
        """Let the servos turn for so long, all under the same load."""
        for _ in range(round(seconds / step_s)):
            self._now_s += step_s
            self.servos.step(step_s, [load_torque_Nm] * len(self.servos.servos), self._now_s)
