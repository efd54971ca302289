"""Emulated servos on one half-duplex bus: bytes in, timed answers out."""

import dataclasses
from collections.abc import Iterator, Sequence

from drivers.simulated.servos.errors import NoSuchServoError
from drivers.simulated.servos.instructions import Group, Single, obey, obey_together, status
from drivers.simulated.servos.line import TimedBytes, overlaid
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
        self._baud_rate = settings.baud_rate
        self._reader = InstructionReader()
        self.set_faults(Faults())

    def set_faults(self, faults: Faults) -> None:
        """Replace the faults; instructions and answers are counted from here."""
        self._faults = faults
        self._heard = 0
        self._answered = 0

    def servo(self, servo_id: int) -> Servo:
        """The servo with this id; raises NoSuchServoError."""
        for servo in self.servos:
            if servo.id == servo_id:
                return servo
        raise NoSuchServoError(
            f"there is no servo {servo_id} on the emulated bus; there are {[servo.id for servo in self.servos]}"
        )

    def receive(self, data: bytes, now_s: float, baud_rate: int | None = None) -> list[Answer]:
        """What the line carries in answer to `data`, sent at `baud_rate`; bytes without a pause between them come together.

        Without a `baud_rate` it is the one of the settings.
        """
        rate = baud_rate or self._baud_rate
        byte_s = BITS_PER_BYTE / rate
        answers: list[Answer] = []
        line_s, in_time = 0.0, False
        for packet in self._reader.feed(data):
            self._heard += 1
            if self._heard in self._faults.unheard:
                continue
            for pause_s, content in self._obey(packet, now_s, rate, byte_s):
                line_s += pause_s + len(content) * byte_s
                for late_s, spoilt in self._spoil(content):
                    if in_time and pause_s == late_s == 0:
                        before = answers[-1]
                        answers[-1] = Answer(before.delay_s + len(content) * byte_s, before.data + spoilt)
                    else:
                        answers.append(Answer(line_s + late_s, spoilt))
                    in_time = late_s == 0
        return answers

    def step(self, dt_s: float, load_torque_Nm: Sequence[float], now_s: float) -> None:
        """Move all servos on; one load for each."""
        for servo, load_Nm in zip(self.servos, load_torque_Nm, strict=True):
            servo.step(dt_s, load_Nm, now_s)

    def _obey(self, packet: Received, now_s: float, rate: int, byte_s: float) -> list[TimedBytes]:
        awake = [servo for servo in self.servos if servo.is_awake(now_s) and servo.baud_rate == rate]
        listening: dict[int, list[Servo]] = {}
        for servo in awake:
            if servo.id not in self._faults.silent:
                listening.setdefault(servo.id, []).append(servo)
        addressed = listening.get(packet.servo, [])
        if not packet.intact:
            return overlaid([status(servo, CRC_ERROR) for servo in addressed], byte_s)
        for servo in awake:
            servo.hear(now_s)
        if packet.code in tuple(Group):
            return obey_together(packet, listening, byte_s)
        everyone = [sharing for _, sharing in sorted(listening.items())]
        answers = [
            answer
            for sharing in (everyone if packet.servo == BROADCAST else [addressed])
            for answer in overlaid([one for servo in sharing for one in obey(servo, packet, now_s)], byte_s)
        ]
        return answers if packet.servo != BROADCAST or packet.code == Single.PING else []

    def _spoil(self, data: bytes) -> Iterator[TimedBytes]:
        """What a fault leaves of the next answer, and how late it comes."""
        self._answered += 1
        number, faults = self._answered, self._faults
        if number in faults.drop:
            return
        if number in faults.truncate:
            data = data[: len(data) // 2]
        if number in faults.corrupt:
            data = data[:-3] + bytes((data[-3] ^ 0x40,)) + data[-2:]
        if number in faults.noise:
            data = faults.noise_bytes + data
        late_s = faults.delay_s if number in faults.delay else 0.0
        yield late_s, data
        if number in faults.double:
            yield late_s + faults.double_after_s, data
