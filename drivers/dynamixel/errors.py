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
    |-- HardwareError          a servo's own error bits, named
    |-- WrongModelError        a servo that this driver does not know, or whose firmware is too old
    |-- WrongSetupError        settings kept in a servo's EEPROM are not what the bench needs
    `-- UnconfirmedError       a servo acknowledged, and reads back something else
"""

from collections.abc import Mapping, Sequence

from drivers.actuators import ActuatorError
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
    """Servos `silent` did not answer in time; `answers` holds what the others said."""

    def __init__(
        self, port: str, silent: Sequence[int], answers: Mapping[int, StatusPacket], within_s: float
    ) -> None:
        """Name the silent servos."""
        heard = f"; servos {sorted(answers)} answered" if answers else ""
        super().__init__(f"{port}: no answer from servo {_ids(silent)} within {within_s * 1e3:.0f} ms{heard}")
        self.silent = tuple(silent)
        self.answers = dict(answers)


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
        super().__init__(port, silent, answers, within_s)
        self.args = (f"{self.args[0]}; received instead: {rubbish[:24].hex(' ')}",)
        self.rubbish = rubbish


class StatusError(ServoError):
    """Servo `servo` refused an instruction; `error` is the number in its answer."""

    def __init__(self, port: str, servo: int, error: int, doing: str) -> None:
        """Say what was asked and what the number means."""
        meaning = ERROR_MEANINGS.get(error, "unknown error number")
        super().__init__(f"{port}: servo {servo} refused to {doing}: {meaning} (error {error})")
        self.servo = servo
        self.error = error


class HardwareError(ServoError):
    """Servos report hardware errors: `bits` by servo id. A servo that shut down needs a reboot."""

    def __init__(self, port: str, bits: Mapping[int, int]) -> None:
        """Name the errors."""
        named = "; ".join(f"servo {servo}: {hardware_error_names(value)}" for servo, value in bits.items())
        super().__init__(f"{port}: hardware error, reboot needed: {named}")
        self.bits = dict(bits)


class WrongModelError(ServoError):
    """A servo is of a model that this driver does not know, or its firmware is too old."""


class WrongSetupError(ServoError):
    """What a servo keeps in its EEPROM is not what the bench needs."""


class UnconfirmedError(ServoError):
    """A servo does not read back what was written."""


class RestartedError(ServoError):
    """A servo has restarted by itself: it is relaxed, and which turn it is in is not known any more."""


def _ids(servos: Sequence[int]) -> str:
    return ", ".join(str(servo) for servo in servos)
