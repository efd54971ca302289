"""Emulated servos on one half-duplex bus: bytes in, timed answers out."""

import dataclasses
from collections.abc import Sequence

from drivers.simulated.servos.instructions import Group, Single, TimedBytes, obey, obey_together, status
from drivers.simulated.servos.memory import CRC_ERROR
from drivers.simulated.servos.packets import InstructionReader, Received
from drivers.simulated.servos.servo import Servo
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults

BROADCAST = 0xFE
BITS_PER_BYTE = 10


@dataclasses.dataclass(frozen=True, slots=True)
class Answer:
    """Bytes that the line has carried `delay_s` after the instruction arrived."""

    delay_s: float
    data: bytes


class ServoBus:
    """All servos of one bus. Pure: time is handed in, and must not run backwards."""

    def __init__(self, settings: EmulatedServosSettings) -> None:
        """Servos just powered on, nothing wrong with the line."""
        self.servos = [Servo(settings, servo_id) for servo_id in settings.ids]
        self._byte_s = BITS_PER_BYTE / settings.baud_rate
        self._reader = InstructionReader()
        self._faults = Faults()
        self._answered = 0

    def set_faults(self, faults: Faults) -> None:
        """Replace the faults; answers are counted from here."""
        self._faults = faults
        self._answered = 0

    def receive(self, data: bytes, now_s: float) -> list[Answer]:
        """What the line carries in answer to `data`; bytes that follow each other without a pause come together."""
        answers: list[Answer] = []
        line_s = 0.0
        for packet in self._reader.feed(data):
            for pause_s, content in self._obey(packet, now_s):
                line_s += pause_s + len(content) * self._byte_s
                late_s, spoilt = self._spoil(content)
                if answers and pause_s == late_s == 0:
                    before = answers[-1]
                    answers[-1] = Answer(before.delay_s + len(content) * self._byte_s, before.data + spoilt)
                elif spoilt:
                    answers.append(Answer(line_s + late_s, spoilt))
        return answers

    def step(self, dt_s: float, load_torque_Nm: Sequence[float], now_s: float) -> None:
        """Move all servos on; one load for each."""
        for servo, load_Nm in zip(self.servos, load_torque_Nm, strict=True):
            servo.step(dt_s, load_Nm, now_s)

    def _obey(self, packet: Received, now_s: float) -> list[TimedBytes]:
        awake = [servo for servo in self.servos if servo.is_awake(now_s)]
        listening = {servo.id: servo for servo in awake if servo.id not in self._faults.silent}
        addressed = listening.get(packet.servo)
        if not packet.intact:
            return [status(addressed, CRC_ERROR)] if addressed else []
        for servo in awake:
            servo.hear(now_s)
        if packet.code in tuple(Group):
            return obey_together(packet, listening)
        if packet.servo == BROADCAST:
            answers = [
                answer for _, servo in sorted(listening.items()) for answer in obey(servo, packet, now_s)
            ]
            return answers if packet.code == Single.PING else []
        return obey(addressed, packet, now_s) if addressed else []

    def _spoil(self, data: bytes) -> TimedBytes:
        """By how much a fault delays the next answer, and what it leaves of it."""
        self._answered += 1
        number, faults = self._answered, self._faults
        if number in faults.drop:
            return 0.0, b""
        if number in faults.truncate:
            data = data[: len(data) // 2]
        if number in faults.corrupt:
            data = data[:-3] + bytes((data[-3] ^ 0x40,)) + data[-2:]
        return faults.delay_s if number in faults.delay else 0.0, data
