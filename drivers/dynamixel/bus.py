"""Conversations with the servos on one bus: every one ends in a deadline, a typed error or a checked answer."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Self

from drivers.dynamixel import protocol
from drivers.dynamixel.control_table import HARDWARE_ERROR_STATUS, Register
from drivers.dynamixel.errors import CorruptAnswerError, HardwareError, NoAnswerError, StatusError
from drivers.dynamixel.hearing import Hearing
from drivers.dynamixel.port import Line
from drivers.dynamixel.protocol import Instruction, Packet, PacketParser, StatusPacket

PROMPT_S = 0.002
"""How long after its time on the wire an answer is usually there. A sync read that is asked again and again, as in every cycle,
is repeated when that is over, so that a lost packet is made up for within the cycle; its last attempt waits for all the time
that is allowed. Elsewhere, and while answers to such a repetition may still come, each attempt waits in full."""
QUIET_S = 0.002
"""How long nothing may have come before another question is asked: longer than a servo's longest return delay (508 us) and an
adapter's 1 ms, so that a second answer is not taken for the answer to that question."""
REBOOT_DEADLINE_S = 2.0
REBOOT_POLL_S = 0.02


@dataclasses.dataclass(frozen=True, slots=True)
class Identity:
    """What a servo says of itself when pinged."""

    model_number: int
    firmware: int


class DynamixelBus:
    """Servos that speak Protocol 2.0 on one line.

    Every method raises PortLostError when the line is not open or goes away; those that wait for answers raise
    NoAnswerError or CorruptAnswerError after `retries` repetitions, and StatusError when a servo refuses. The longest
    they take is the time on the wire and (1 + retries) answer timeouts, or (3 + retries) when the question is another than
    the one before, whose late answers must not be taken for its own.
    `alerts` holds the servos whose newest answer had the alert bit: their hardware reports an error.
    """

    def __init__(self, line: Line, *, answer_timeout_s: float = 0.02, retries: int = 2) -> None:
        """Remember the line; `open` opens it."""
        self.alerts: set[int] = set()
        self._line = line
        self._answer_timeout_s = answer_timeout_s
        self._attempts = 1 + retries
        self._question: object = None
        self._late_until_s = 0.0
        self._heard_s = 0.0

    @property
    def port(self) -> str:
        """The port's path."""
        return self._line.path

    @property
    def is_open(self) -> bool:
        """Whether the port is held."""
        return self._line.is_open

    def open(self) -> None:
        """Take the port; raises PortMissingError, PortBusyError or PortError."""
        self._line.open()

    def close(self) -> None:
        """Let the port go; `open` may take it again."""
        self._line.close()

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
        self._line.send(protocol.sync_write(register.address, data).to_bytes())

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

        def ask(missing: Sequence[int], attempt: int) -> Instruction:
            build = protocol.sync_read if attempt else protocol.fast_sync_read
            return build(missing, address, size)

        question = (address, size)
        answers = self._converse(
            servos,
            size,
            question,
            ask,
            f"read {size} bytes at {address}",
            in_a_hurry=question == self._question and self._line.now_s() >= self._late_until_s,
        )
        return {servo: answers[servo].parameters for servo in servos}

    def overhear(self, instruction: Instruction, wait_s: float) -> list[Packet]:
        """Send once and return all that comes until `wait_s` after its time on the wire: answers, second ones, rubbish."""
        packet = instruction.to_bytes()
        self._line.send(packet)
        deadline_s = self._line.now_s() + self._line.transfer_time_s(len(packet)) + wait_s
        parser = PacketParser()
        packets: list[Packet] = []
        while data := self._line.receive(deadline_s):
            packets += parser.receive(data)
        return packets + parser.give_up_waiting()

    def check_hardware(self, servos: Sequence[int]) -> None:
        """Raise HardwareError when one of the servos reports a hardware error."""
        bits = self.sync_read(servos, HARDWARE_ERROR_STATUS)
        if any(bits.values()):
            raise HardwareError(self.port, {servo: value for servo, value in bits.items() if value})

    def reboot(self, servo: int) -> None:
        """Restart a servo and wait until it answers again; its RAM is as after power-on."""
        self._ask(protocol.reboot(servo), 0, "reboot")
        deadline_s = self._line.now_s() + REBOOT_DEADLINE_S
        while True:
            self._line.pause(REBOOT_POLL_S)
            try:
                self.ping(servo)
            except NoAnswerError:
                if self._line.now_s() > deadline_s:
                    raise
            else:
                return

    def _ask(self, instruction: Instruction, size: int, doing: str) -> StatusPacket:
        servo = instruction.id
        return self._converse([servo], size, instruction, lambda _missing, _attempt: instruction, doing)[
            servo
        ]

    def _converse(
        self,
        servos: Sequence[int],
        size: int,
        question: object,
        ask: Callable[[Sequence[int], int], Instruction],
        doing: str,
        *,
        in_a_hurry: bool = False,
    ) -> dict[int, StatusPacket]:
        """Ask those that have not answered until all have, and see that none refuses.

        What the last attempt left open is an error, and whatever any answer of any attempt complained of is in its text.
        """
        if question != self._question:
            self._question = question
            self._await_quiet()
        began_s = self._line.now_s()
        answers: dict[int, StatusPacket] = {}
        rubbish, missing = b"", list(servos)
        for attempt in range(self._attempts):
            patience_s = self._answer_timeout_s
            if in_a_hurry and attempt == self._attempts - 1:
                patience_s = max(patience_s, self._attempts * patience_s - (self._line.now_s() - began_s))
            elif in_a_hurry:
                patience_s = min(PROMPT_S, patience_s)
            heard = self._attempt(ask(missing, attempt), missing, size, patience_s)
            answers |= heard.answers
            rubbish = heard.rubbish
            missing = [servo for servo in servos if servo not in answers or _garbled(answers[servo])]
            if not missing:
                break
        for answer in answers.values():
            (self.alerts.add if answer.alert else self.alerts.discard)(answer.id)
        if silent := [servo for servo in missing if servo not in answers]:
            self._question = None  # whatever comes now is too late
            waited_s = self._line.now_s() - began_s
            if rubbish:
                raise CorruptAnswerError(self.port, silent, answers, waited_s, rubbish)
            raise NoAnswerError(self.port, silent, answers, waited_s)
        refusals = [answer for answer in answers.values() if answer.error]
        if refusals:
            others = [answer for answer in answers.values() if answer is not refusals[0]]
            raise StatusError(self.port, refusals[0], doing, others)
        return answers

    def _attempt(
        self, instruction: Instruction, servos: Sequence[int], size: int, patience_s: float
    ) -> Hearing:
        """Send once; what was heard in answer until all of `servos` had answered, or patience was at its end."""
        line, packet = self._line, instruction.to_bytes()
        began_s = line.now_s()
        sent_s = began_s + line.transfer_time_s(len(packet))
        answered_s = sent_s + line.transfer_time_s(len(servos) * (protocol.EMPTY_STATUS_SIZE + size))
        none_is_late = began_s >= self._late_until_s
        self._late_until_s = answered_s + 2 * self._answer_timeout_s
        one_by_one = instruction.code != protocol.Code.FAST_SYNC_READ
        hearing = Hearing(servos, size, one_by_one=one_by_one)
        line.send(packet)
        deadline_s = sent_s + patience_s  # for the first of it; nobody will answer what nobody has heard
        while not hearing.complete and (data := line.receive(deadline_s)):
            hearing.receive(data)
            deadline_s = answered_s + patience_s
        if not hearing.complete:
            hearing.end()
        if hearing.received:
            self._heard_s = line.now_s()
        if hearing.complete and (none_is_late or not one_by_one):
            self._late_until_s = 0.0
        return hearing

    def _await_quiet(self) -> None:
        """Answers do not say what they answer, so none to another question may come as late as after this one.

        A late answer to the same question is welcome: it says the same. What has come by then is dropped when sending.
        """
        quiet_at_s = max(self._late_until_s, self._heard_s + QUIET_S)
        if (wait_s := quiet_at_s - self._line.now_s()) > 0:
            self._line.pause(wait_s)


def _garbled(answer: StatusPacket) -> bool:
    """Whether the question did not come through, and is worth repeating."""
    return answer.error == protocol.GARBLED_INSTRUCTION
