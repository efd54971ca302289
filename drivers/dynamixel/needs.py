"""What the EEPROM of a bench's servo has to hold, register by register. Pure."""

import math
from collections.abc import Mapping

from drivers.dynamixel import control_table as table
from drivers.dynamixel.axis import Axis
from drivers.dynamixel.control_table import Register
from drivers.dynamixel.settings import ServoSettings

ANSWERS: Mapping[Register, int] = {
    table.OPERATING_MODE: table.CURRENT_BASED_POSITION_MODE,
    table.RETURN_DELAY_TIME: 0,
    table.DRIVE_MODE: 0,
}
"""Without these the driver would misunderstand the servo: current-bounded multi-turn positions; answers without delay;
positive is counter-clockwise, profiles by velocity."""

_NO_SECONDARY_ID = 255
_SHUTDOWN_AT = 0x34
"""Overheating, electrical shock, overload: the factory's choice, and never less."""


def eeprom_needs(axis: Axis, settings: ServoSettings, shutdown: int) -> dict[Register, int]:
    """What the servo of `axis` should hold, beside its id and baud rate; `shutdown` is what its Shutdown holds now.

    Limits are as tight as the bench allows, so that the servo itself keeps them whoever talks to it. Position limits count
    only in a mode that the bench does not use; they are opened, so that none stays behind from another robot.
    """
    return {
        **ANSWERS,
        table.SECONDARY_ID: _NO_SECONDARY_ID,
        table.STARTUP_CONFIGURATION: 0,
        table.CURRENT_LIMIT: math.ceil(axis.settings.max_current_ma / axis.model.current_unit_ma),
        table.VELOCITY_LIMIT: math.ceil(settings.profile_velocity_rad_s / table.RAD_S_PER_VELOCITY),
        table.TEMPERATURE_LIMIT: settings.temperature_limit_c,
        table.MAX_POSITION_LIMIT: table.TICKS_PER_TURN - 1,
        table.MIN_POSITION_LIMIT: 0,
        table.SHUTDOWN: shutdown | _SHUTDOWN_AT,
    }
