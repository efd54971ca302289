"""Errors of the controller.

NodalError
`-- ControllerError
    |-- ControllerSetupError      settings that do not fit the robot, or name a law that does not exist
    |   `-- RealTimeRefusedError  the system does not allow what [controller.real_time] asks for
    |-- TargetError               a target that is refused; nothing moves because of it
    |   |-- UnknownNodeError      it names a nodal point that sensing does not report
    |   |-- UnreachableError      a point lies where the robot cannot bring it
    |   |-- TooFastError          it moves or jumps faster than nodal points or axes may
    |   |-- TooLongError          its path is longer than can be checked before anything moves
    |   |-- TooCloseError         it leads the robot into a forbidden region, or too near to one
    |   `-- NoWayError            no way to it was found that keeps clear of regions and within travels
    |-- ClockError                a cycle's time that is no time; nothing can be done without one
    |-- CommandNotFiniteError     a command that no actuator may see
    `-- FaultError                what puts the controller into `fault`; controller/faults.py holds one class for each
"""

from typing import ClassVar

from messaging.errors import NodalError


class ControllerError(NodalError):
    """Something the controller cannot or will not do."""


class ControllerSetupError(ControllerError):
    """The settings do not describe a controller for this robot."""


class RealTimeRefusedError(ControllerSetupError):
    """The system does not let the control loop have the scheduling, memory or cores that it was set to have."""


class TargetError(ControllerError):
    """A target is refused."""


class UnknownNodeError(TargetError):
    """A target names a nodal point that the newest shape does not have."""


class UnreachableError(TargetError):
    """A point of a target cannot be reached."""


class TooFastError(TargetError):
    """A target moves faster than `maximum_node_speed_mm_s`, or asks more of an axis than its rate."""


class TooLongError(TargetError):
    """A target's path is longer than what can be looked at in the time that there is."""


class TooCloseError(TargetError):
    """A target, or the straight way to it, leads the robot nearer to a forbidden region than `keep_clear_mm`."""


class NoWayError(TargetError):
    """Planning found no way to a target."""


class ClockError(ControllerError):
    """A cycle's time, or the time since the one before, is not finite or does not go on."""


class CommandNotFiniteError(ControllerError):
    """A command holds a value that is not finite."""


class FaultError(ControllerError):
    """The reason of a fault; its text names the value and what is allowed, and where both are numbers they are here too.

    `code` is what programs know it by, `advice` what the operator can do.
    """

    code: ClassVar[str]
    advice: ClassVar[str]

    def __init__(self, text: str, *, value: float = 0.0, limit: float = 0.0, unit: str = "") -> None:
        """Without a unit there is neither value nor limit."""
        super().__init__(text)
        self.value, self.limit, self.unit = float(value), float(limit), unit
