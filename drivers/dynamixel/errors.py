"""Errors of the Dynamixel servo bus.

ActuatorError
`-- ServoError                 every error below
    |-- PortError              the serial port cannot be opened or used
    |   |-- PortMissingError   there is no such device
    |   |-- PortBusyError      another program has it
    |   `-- PortLostError      it is not open (any more): unplugged, closed, or it takes no bytes
    |-- NoAnswerError          servos that stayed silent; carries the answers of the others
    |   `-- CorruptAnswerError what came was not the answer: noise, a collision, two servos with one id
    |-- StatusError            a servo refused an instruction, and says why
    |-- HardwareError          a servo's own error bits, named; a ServoAlarmError too
    |-- WrongModelError        a servo that this driver does not know, or whose firmware is too old
    |-- WrongSetupError        settings kept in a servo's EEPROM are not what the bench needs
    |-- UnconfirmedError       a servo acknowledged, and reads back something else
    `-- RestartedError         a servo restarted by itself, and forgot its turns; a ServoRestartedError too
"""

from collections.abc import Iterable, Mapping, Sequence

from drivers.actuators import ActuatorError, ServoAlarmError, ServoRestartedError
from drivers.dynamixel.control_table import hardware_error_names
from drivers.dynamixel.protocol import ERROR_MEANINGS, StatusPacket


class ServoError(ActuatorError):
    """Something is wrong on the servo bus."""


class PortError(ServoError):
    """The serial port cannot be opened or used."""


class PortMissingError(PortError):
    """There is no such serial device."""


class PortBusyError(PortError):
    """Another program has the serial port open."""


class PortLostError(PortError):
    """The serial port is not open (any more)."""


class NoAnswerError(ServoError):
    """Servos `silent` did not answer in time; `answers` holds what the others said, their own trouble included."""

    def __init__(
        self,
        port: str,
        silent: Sequence[int],
        answers: Mapping[int, StatusPacket],
        within_s: float,
        rubbish: bytes = b"",
    ) -> None:
        """Name the silent servos, and what the others complain of."""
        instead = (
            f"; received instead: {rubbish[:24].hex(' ')} (noise on the line, or two servos with one id: "
            "`nodal servos list` tells)"
            if rubbish
            else ""
        )
        heard = f"; servos {sorted(answers)} answered" if answers else ""
        super().__init__(
            f"{port}: no answer from servo {_ids(silent)} within {within_s * 1e3:.0f} ms{instead}{heard}"
            f"{complaints(answers.values())}"
        )
        self.silent = tuple(silent)
        self.answers = dict(answers)

    def add(self, words: str) -> None:
        """Say more."""
        self.args = (f"{self.args[0]}{words}",)


class CorruptAnswerError(NoAnswerError):
    """Bytes came, but no valid answer from servos `silent`."""

    def __init__(
        self,
        port: str,
        silent: Sequence[int],
        answers: Mapping[int, StatusPacket],
        within_s: float,
        rubbish: bytes,
    ) -> None:
        """Show the beginning of what came instead."""
        super().__init__(port, silent, answers, within_s, rubbish)
        self.rubbish = rubbish


class StatusError(ServoError):
    """Servo `servo` refused an instruction; `error` is the number in its answer."""

    def __init__(
        self, port: str, refusal: StatusPacket, doing: str, others: Iterable[StatusPacket] = ()
    ) -> None:
        """Say what was asked, what the number means, and what other servos complain of."""
        alert = " and reports a hardware error" if refusal.alert else ""
        super().__init__(
            f"{port}: servo {refusal.id} refused to {doing}: {_meaning(refusal.error)}{alert}{complaints(others)}"
        )
        self.servo = refusal.id
        self.error = refusal.error


class HardwareError(ServoError, ServoAlarmError):
    """Servos report hardware errors: `bits` by servo id. A servo that shut down needs a reboot."""

    def __init__(self, port: str, bits: Mapping[int, int]) -> None:
        """Name the errors."""
        super().__init__(
            f"{port}: hardware error{hardware_words(bits)}; find the cause, then `nodal servos reboot`"
        )
        self.bits = dict(bits)


class WrongModelError(ServoError):
    """A servo is of a model that this driver does not know, or its firmware is too old."""


class WrongSetupError(ServoError):
    """What a servo keeps in its EEPROM is not what the bench needs."""


class UnconfirmedError(ServoError):
    """A servo does not read back what was written."""


class RestartedError(ServoError, ServoRestartedError):
    """A servo has restarted by itself: it is relaxed, and which turn it is in is not known any more."""


def complaints(answers: Iterable[StatusPacket]) -> str:
    """What these answers say besides their parameters, to be put behind another text; nothing when all is well."""
    return "".join(
        f"; servo {answer.id} "
        + " and ".join(
            words
            for words in (
                f"refuses: {_meaning(answer.error)}" if answer.error else "",
                "reports a hardware error" if answer.alert else "",
            )
            if words
        )
        for answer in answers
        if answer.error or answer.alert
    )


def hardware_words(bits: Mapping[int, int]) -> str:
    """Hardware errors by servo id, to be put behind another text; nothing when all is well."""
    return "".join(
        f"; servo {servo}: {hardware_error_names(value)}" for servo, value in bits.items() if value
    )


def _meaning(error: int) -> str:
    return f"{ERROR_MEANINGS.get(error, 'unknown error number')} (error {error})"


def _ids(servos: Sequence[int]) -> str:
    return ", ".join(str(servo) for servo in servos)
