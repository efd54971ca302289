"""Conversations with the servos on one bus: every one ends in a deadline, a typed error or a checked answer."""

import dataclasses
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

from drivers.dynamixel import protocol
from drivers.dynamixel.control_table import HARDWARE_ERROR_STATUS, Register
from drivers.dynamixel.errors import CorruptAnswerError, HardwareError, NoAnswerError, StatusError
from drivers.dynamixel.port import SerialPort
from drivers.dynamixel.protocol import (
    Dropped,
    FastStatusPacket,
    Instruction,
    PacketParser,
    StatusPacket,
)

REBOOT_DEADLINE_S = 2.0
REBOOT_POLL_S = 0.02


@dataclasses.dataclass(frozen=True, slots=True)
class Identity:
    """What a servo says of itself when pinged."""

    model_number: int
    firmware: int


class DynamixelBus:
    """Servos that speak Protocol 2.0 on one serial port.

    Every method raises PortLostError when the port is not open or goes away; those that wait for answers raise
    NoAnswerError or CorruptAnswerError after `retries` repetitions, and StatusError when a servo refuses. The longest
    they take is (2 + retries) answer timeouts and the time on the wire.
    `alerts` holds the servos whose newest answer had the alert bit: their hardware reports an error.
    """

    def __init__(
        self, port: str, *, baud_rate: int = 1_000_000, answer_timeout_s: float = 0.02, retries: int = 2
    ) -> None:
        """Remember the port; `open` opens it."""
        self.alerts: set[int] = set()
        self._port = SerialPort(port, baud_rate)
        self._answer_timeout_s = answer_timeout_s
        self._attempts = 1 + retries
        self._late_question: object = None
        self._late_until_s = 0.0

    @property
    def port(self) -> str:
        """The port's path."""
        return self._port.path

    @property
    def is_open(self) -> bool:
        """Whether the port is held."""
        return self._port.is_open

    def open(self) -> None:
        """Take the port; raises PortMissingError, PortBusyError or PortError."""
        self._port.open()

    def close(self) -> None:
        """Let the port go; `open` may take it again."""
        self._port.close()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def ping(self, servo: int) -> Identity:
        """Model and firmware of a servo."""
        answer = self._ask(protocol.ping(servo), 3, "answer a ping").parameters
        return Identity(int.from_bytes(answer[:2], "little"), answer[2])

    def read(self, servo: int, register: Register) -> int:
        """The value of one register."""
        return register.from_bytes(self.read_bytes(servo, register.address, register.size))

    def read_bytes(self, servo: int, address: int, size: int) -> bytes:
        """`size` bytes from `address`."""
        return self._ask(
            protocol.read(servo, address, size), size, f"read {size} bytes at {address}"
        ).parameters

    def write(self, servo: int, register: Register, value: int) -> None:
        """Write one register; returns when the servo has acknowledged it (which needs status return level 2)."""
        instruction = protocol.write(servo, register.address, register.to_bytes(value))
        self._ask(instruction, 0, f"set {register.name} to {value}")

    def write_bytes(self, servo: int, address: int, data: bytes) -> None:
        """Write bytes that cover whole registers from `address`; returns when the servo has acknowledged them."""
        self._ask(protocol.write(servo, address, data), 0, f"take {len(data)} bytes at {address}")

    def sync_write(self, register: Register, values: Mapping[int, int]) -> None:
        """Write one register of several servos, in one packet that nobody answers."""
        data = {servo: register.to_bytes(value) for servo, value in values.items()}
        self._port.send(protocol.sync_write(register.address, data).to_bytes())

    def sync_read(self, servos: Sequence[int], register: Register) -> dict[int, int]:
        """One register of several servos."""
        blocks = self.sync_read_bytes(servos, register.address, register.size)
        return {servo: register.from_bytes(block) for servo, block in blocks.items()}

    def sync_read_bytes(self, servos: Sequence[int], address: int, size: int) -> dict[int, bytes]:
        """The same `size` bytes of several servos, in their order.

        The first attempt is a fast sync read, where one silent servo silences those behind it; further attempts ask the
        silent ones alone, by plain sync read. The error after the last names who is still silent, and carries the answers
        of the others.
        """
        answers: dict[int, StatusPacket] = {}
        rubbish, waited_s = b"", 0.0
        self._await_late_answers(question := (address, size))
        for attempt in range(self._attempts):
            missing = [servo for servo in servos if servo not in answers]
            build = protocol.sync_read if attempt else protocol.fast_sync_read
            instruction = build(missing, address, size)
            heard, rubbish, took_s = self._attempt(instruction, missing, size, question)
            waited_s += took_s
            for answer in heard.values():
                self._check(answer, f"read {size} bytes at {address}")
            answers |= heard
            if len(answers) == len(servos):
                return {servo: answers[servo].parameters for servo in servos}
        raise self._silence([servo for servo in servos if servo not in answers], answers, waited_s, rubbish)

    def check_hardware(self, servos: Sequence[int]) -> None:
        """Raise HardwareError when one of the servos reports a hardware error."""
        bits = self.sync_read(servos, HARDWARE_ERROR_STATUS)
        if any(bits.values()):
            raise HardwareError(self.port, {servo: value for servo, value in bits.items() if value})

    def reboot(self, servo: int) -> None:
        """Restart a servo and wait until it answers again; its RAM is as after power-on."""
        self._ask(protocol.reboot(servo), 0, "reboot")
        deadline_s = time.monotonic() + REBOOT_DEADLINE_S
        while True:
            time.sleep(REBOOT_POLL_S)
            try:
                self.ping(servo)
            except NoAnswerError:
                if time.monotonic() > deadline_s:
                    raise
            else:
                return

    def _ask(self, instruction: Instruction, size: int, doing: str) -> StatusPacket:
        servo = instruction.id
        rubbish, waited_s = b"", 0.0
        answer: StatusPacket | None = None
        self._await_late_answers(instruction)
        for _ in range(self._attempts):
            heard, rubbish, took_s = self._attempt(instruction, [servo], size, instruction)
            waited_s += took_s
            answer = heard.get(servo)
            if answer is not None and answer.error != protocol.GARBLED_INSTRUCTION:
                break
        if answer is None:
            raise self._silence([servo], {}, waited_s, rubbish)
        return self._check(answer, doing)

    def _attempt(
        self, instruction: Instruction, servos: Sequence[int], size: int, question: object
    ) -> tuple[dict[int, StatusPacket], bytes, float]:
        """Send once; who of `servos` answered with `size` parameters, what else was received, and the time it took."""
        packet = instruction.to_bytes()
        start_s = time.monotonic()
        expected_bytes = len(packet) + len(servos) * (protocol.EMPTY_STATUS_SIZE + size)
        deadline_s = start_s + self._answer_timeout_s + self._port.transfer_time_s(expected_bytes)
        none_is_late = start_s >= self._late_until_s
        self._late_until_s, self._late_question = deadline_s + self._answer_timeout_s, question
        self._port.send(packet)
        parser = PacketParser()
        answers: dict[int, StatusPacket] = {}
        received, rubbish = b"", b""
        while len(answers) < len(servos):
            data = self._port.receive(deadline_s)
            received += data
            for event in parser.receive(data) if data else parser.give_up_waiting():
                match event:
                    case StatusPacket() if event.id in servos and (
                        len(event.parameters) == size or event.error
                    ):
                        answers[event.id] = event
                    case FastStatusPacket(raw):
                        answers |= _parts_of_one(raw, servos, size)
                    case Dropped(dropped):
                        rubbish += dropped
            if not data:
                answers |= _parts_of_one(protocol.salvage_fast_status(received, size), servos, size)
                break
        if none_is_late and len(answers) == len(servos):
            self._late_until_s = 0.0
        return answers, rubbish, time.monotonic() - start_s

    def _await_late_answers(self, question: object) -> None:
        """Answers do not say what they answer, so one to another question must not come as late as after this one.

        A late answer to the same question is welcome: it says the same. What has come by then is dropped when sending.
        """
        if question != self._late_question:
            time.sleep(max(0.0, self._late_until_s - time.monotonic()))

    def _check(self, answer: StatusPacket, doing: str) -> StatusPacket:
        (self.alerts.add if answer.alert else self.alerts.discard)(answer.id)
        if answer.error:
            raise StatusError(self.port, answer.id, answer.error, doing)
        return answer

    def _silence(
        self, silent: Sequence[int], answers: Mapping[int, StatusPacket], waited_s: float, rubbish: bytes
    ) -> NoAnswerError:
        if rubbish:
            return CorruptAnswerError(self.port, silent, answers, waited_s, rubbish)
        return NoAnswerError(self.port, silent, answers, waited_s)


def _parts_of_one(raw: bytes, servos: Sequence[int], size: int) -> dict[int, StatusPacket]:
    """Answers in the common answer to a fast sync read; none when it is not the answer to this question."""
    parts = {part.id: part for part in protocol.split_fast_status(raw, size)}
    return parts if [*parts] == [*servos][: len(parts)] else {}
