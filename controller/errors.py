"""Errors of the controller.

NodalError
`-- ControllerError
    |-- ControllerSetupError      settings that do not fit the robot, or name a law that does not exist
    |   `-- RealTimeRefusedError  the system does not allow what [controller.real_time] asks for
    |-- TargetError               a target that is refused; nothing moves because of it
    |   |-- UnknownNodeError      it names a nodal point that sensing does not report
    |   |-- UnreachableError      a point lies where the robot cannot bring it
    |   `-- TooFastError          it moves or jumps faster than nodal points may
    |-- CommandNotFiniteError     a command that no actuator may see
    `-- FaultError                what puts the controller into `fault`
        |-- DriveLostError        no tendon drive, or it stopped answering
        |-- TorqueLostError       a servo let go by itself
        |-- ServoAlarmError       a servo reports hardware error bits
        |-- ExcessCurrentError    a servo drew too much current for too long
        |-- TravelError           an axis stands, or was asked to stay, beyond its travel
        |-- SensingLostError      no trusted shape for longer than a hold may last
        |-- HomingTimeoutError    the robot did not become straight in time
        `-- LawFailedError        the law's command was refused by the limits
"""

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
    """A target moves faster than `maximum_node_speed_mm_s`."""


class CommandNotFiniteError(ControllerError):
    """A command holds a value that is not finite."""


class FaultError(ControllerError):
    """The reason of a fault; its text names the value and what is allowed."""


class DriveLostError(FaultError):
    """The tendon drive does not answer."""


class TorqueLostError(FaultError):
    """A servo no longer holds its position, though it should."""


class ServoAlarmError(FaultError):
    """A servo's hardware error bits are set."""


class ExcessCurrentError(FaultError):
    """A servo's current was above the limit for longer than allowed."""


class TravelError(FaultError):
    """An axis is beyond its travel."""


class SensingLostError(FaultError):
    """Shapes stayed stale, flagged or refused for too long."""


class HomingTimeoutError(FaultError):
    """Homing did not end in time."""


class LawFailedError(FaultError):
    """The law produced a command that cannot be used."""
