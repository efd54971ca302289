"""What puts the controller into `fault`: one class for each kind, with its code and what the operator can do about it.

In every one of these the servos let all tendons go in the cycle that finds it, and nothing but the operator's `home` or
`relax` leads out of it. docs/faults.md is made from this file.
"""

from controller.errors import FaultError

_SEE = "Look at the robot, then `nodal do home`."


class DriveLostError(FaultError):
    """The tendon drive does not answer, or what it answers is of no use."""

    code = "drive_lost"
    advice = (
        "Check the servos' power and their cable. The drive is sought again every second; when `nodal do status` no longer "
        "complains, `nodal do home`. `nodal servos list` says which servos answer, once `nodal control` has ended: a serial port "
        "has one user at a time."
    )


class WatchdogExpiredError(FaultError):
    """The drive heard nothing for longer than its watchdog allows, and stopped by itself."""

    code = "watchdog_expired"
    advice = (
        "The controller or its bus stood still for a moment: see the log for overruns and what else ran on this computer "
        "(docs/real-time.md). Then `nodal do home`."
    )


class ServoRestartedError(FaultError):
    """A servo restarted by itself and forgot its turns."""

    code = "servo_restarted"
    advice = (
        "Its supply dipped: check the power supply and the plugs, and how many servos hang on one cable. Then `nodal do home`; "
        "the old zero is lost."
    )


class ServoAlarmError(FaultError):
    """A servo's own hardware error bits are set."""

    code = "servo_alarm"
    advice = (
        "Find the cause (overload: something jams or pulls too hard; overheating: let it cool; input voltage: check the supply), "
        "then end `nodal control`, which holds the serial port, `nodal servos reboot`, start it again and `nodal do home`."
    )


class TorqueLostError(FaultError):
    """A servo no longer holds its position, though it should."""

    code = "torque_lost"
    advice = f"A servo let go, or another program switched it off. {_SEE}"


class ExcessCurrentError(FaultError):
    """A servo drew more than `controller.limits.current_ma` for longer than `current_grace_s`."""

    code = "excess_current"
    advice = (
        "Something holds the robot, or its tendons are too tight. Free it by hand, `nodal do relax`, loosen what is tight "
        "(`nodal do jog`), then `nodal do home`."
    )


class TooHotError(FaultError):
    """A servo is hotter than `controller.limits.temperature_c`."""

    code = "too_hot"
    advice = (
        "Let it cool with the tendons relaxed; look for what keeps it under load, such as too much pretension. "
        "Then `nodal do home`."
    )


class SupplyVoltageError(FaultError):
    """A servo's supply was outside `controller.limits.voltage_v` for longer than `voltage_grace_s`."""

    code = "supply_voltage"
    advice = (
        "Check the power supply, its setting and the cables to the servo that is named. Then `nodal do home`."
    )


class TravelError(FaultError):
    """An axis stands beyond its travel, or was asked to stay there for longer than `travel_grace_s`."""

    code = "travel"
    advice = (
        "`nodal do home` takes the present place of tendons as their new zero; a stage must be brought back, or its zero "
        "corrected (docs/servos.md). If it comes again, the target asks for more than the robot "
        "has, or `controller.limits` are narrower than the tendons need."
    )


class NotFollowingError(FaultError):
    """A servo stood further than `controller.limits.following_mm` from where it was sent, and came no nearer, for
    `following_grace_s`.
    """

    code = "not_following"
    advice = (
        "The servo cannot pull as hard as it should, or turns too slowly: look for what jams, and compare its current limit "
        "and profile velocity with the bench's. Then `nodal do home`."
    )


class SensingLostError(FaultError):
    """No trusted shape came for longer than `controller.sensing.hold_at_most_s`."""

    code = "sensing_lost"
    advice = (
        "The reason says what was wrong with the last shapes. See that sensing runs, the cameras see the whole robot, and "
        "nothing stands between them. Then `nodal do home`."
    )


class RegionEnteredError(FaultError):
    """The cameras see a part of the robot inside a forbidden region."""

    code = "region_entered"
    advice = (
        "Lead the robot out by hand, or correct `controller.forbidden` if the region is wrong. Then `nodal do relax` and "
        "`nodal do home`, which looks again."
    )


class HomingTimeoutError(FaultError):
    """The robot did not become straight within `controller.homing.timeout_s`."""

    code = "homing_timeout"
    advice = (
        "See that nothing holds the robot and that the bench file's nodal points and calibration fit it. "
        "`controller.homing.within_mm` says how straight it must become."
    )


class TendonSlackError(FaultError):
    """Homing moved an axis as far as it may, and neither the cameras nor the current noticed."""

    code = "tendon_slack"
    advice = (
        "The tendon that is named is slack, off its pulley or snapped: look, tighten it (`nodal do relax`, then "
        "`nodal do jog`), then `nodal do home`. `controller.homing.search_mm` says how far homing looks."
    )


class WrongWayError(FaultError):
    """Homing pulled an axis, and the robot went another way than the model."""

    code = "wrong_way"
    advice = (
        "The axis is wired or signed the wrong way: compare the order and angles of the tendons in `controller.sections` with "
        "the bench, and the sign of the servo's `mm_per_rad`. Then `nodal do home`."
    )


class LawFailedError(FaultError):
    """The control law raised an error, or its command cannot be used."""

    code = "law_failed"
    advice = "The reason says what the law did. `nodal do home` starts it anew; with another `controller.law` it may not come again."


class OperatorLostError(FaultError):
    """No operator's heartbeat came for `controller.operator.heartbeat_s` and then `hold_s` more."""

    code = "operator_lost"
    advice = "Start what gives the heartbeat (`nodal do watch`, a button box). Then `nodal do home`."


class LoopStalledError(FaultError):
    """Two cycles of the controller lay further apart than `controller.stall_s`."""

    code = "loop_stalled"
    advice = "This computer did something else for too long: see docs/real-time.md, and what else runs on it. Then `nodal do home`."


FAULTS: dict[str, type[FaultError]] = {kind.code: kind for kind in FaultError.__subclasses__()}
"""By code."""
