"""Errors of the roof.

NodalError
|-- BenchFileError         a bench file that cannot be read, or that asks for something impossible
|-- CalibrationFileError   a calibration file that cannot be read, or that does not describe the bench's cameras
|-- CommandError           words on the command line that fit the grammar but mean nothing possible
|-- BusError               a servo bus on which nobody answers, or not the one that is asked for
|-- SetupRefusedError      a servo that must not be set up as it is now; nothing was written
|-- CalibrationError       what was shown or given is not enough to calibrate anything
|-- RobotStoppedError      a robot that is led to be calibrated must not be led on: a fault, a refusal, an axis that does not answer
|   |-- JogRefusedError    a single move that the controller refuses; others may still be possible
|   `-- ServosSilentError  servos that did not answer for a moment; homed anew, the robot may be led on
|-- ProcessError           a process of the bench did not start or does not stay up, or what is waited for does not come
|-- DemoError              the demo cannot go on
|-- ExportError            an export that cannot be written
|-- ReportError            a recording that does not hold what a report needs
`-- ReplayError            a recording that cannot be replayed as asked
"""

from messaging.errors import NodalError


class BenchFileError(NodalError):
    """A bench file is missing, is not TOML, or holds a key or value that is not allowed."""


class CalibrationFileError(NodalError):
    """A calibration file is missing, is not laid out as documented, or does not fit the bench's cameras."""


class CommandError(NodalError):
    """An argument of the command line names something impossible."""


class BusError(NodalError):
    """Nobody answers on the servo bus, or not the servo that was asked for."""


class SetupRefusedError(NodalError):
    """A servo's torque is on, its id is taken, or it shares its id: it is not set up."""


class CalibrationError(NodalError):
    """Calibration cannot be done with what there is; the reason says what is missing."""


class RobotStoppedError(NodalError):
    """The robot must not be led on while it is calibrated; with what the operator can do about it."""

    def __init__(self, reason: str, advice: str = "") -> None:
        """`advice` may be empty."""
        super().__init__(reason)
        self.advice = advice


class JogRefusedError(RobotStoppedError):
    """The controller refuses one move, because of a forbidden region or a limit; the robot stands as it did."""


class ServosSilentError(RobotStoppedError):
    """The controller lost its servos, let go and is in fault: what the robot was led to is over, but nothing need be broken."""


class ProcessError(NodalError):
    """A process of the bench did not become ready in time or died too often, or what is waited for does not come."""


class DemoError(NodalError):
    """The demo cannot go on: the bench is not simulated, its folder is taken, or it does not do what it is asked."""


class ExportError(NodalError):
    """The disk does not take what is exported."""


class ReportError(NodalError):
    """A recording lacks the messages that the report is made of."""


class ReplayError(NodalError):
    """A recording lacks what a replay is made of, or the replay that is asked for is impossible."""
