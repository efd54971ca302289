"""Registers' values as people say them, and the table of `nodal servos list`. Pure."""

from drivers.dynamixel import control_table as table
from drivers.dynamixel.control_table import Model, Register, hardware_error_names
from nodal.servos.scan import FoundServo

_WIDTHS = (4, 12, 9, 9, 24, 7, 9, 6, 5)
HEADER = ("id", "model", "firmware", "baud", "mode", "torque", "position", "V", "C", "hardware error")


def line(cells: tuple[str, ...]) -> str:
    """One line of the table; the last cell may be as long as it likes."""
    return "".join(f"{cell:<{width}}" for cell, width in zip(cells, _WIDTHS, strict=False)) + cells[-1]


def row(servo: FoundServo) -> str:
    """What is to be said of one servo."""
    if servo.identity is None:
        return line((str(servo.id), "?", "?", str(servo.baud_rate), "?", "?", "?", "?", "?", SHARED))
    readings = servo.readings
    return line(
        (
            str(servo.id),
            servo.model_name,
            str(servo.identity.firmware),
            str(servo.baud_rate),
            mode_name(readings[table.OPERATING_MODE]),
            "on" if readings[table.TORQUE_ENABLE] else "off",
            str(readings[table.PRESENT_POSITION]),
            f"{readings[table.PRESENT_INPUT_VOLTAGE] * table.VOLTS_PER_COUNT:.1f}",
            str(readings[table.PRESENT_TEMPERATURE]),
            hardware_error_names(readings[table.HARDWARE_ERROR_STATUS]) or "none",
        )
    )


SHARED = "answers are garbled: two servos with this id? Connect them one at a time"


def mode_name(mode: int) -> str:
    """An operating mode in words."""
    return table.OPERATING_MODES.get(mode, f"mode {mode}")


def value_words(register: Register, value: int, model: Model) -> str:
    """A register's value with what it means, where that is not the value itself."""
    if register is table.OPERATING_MODE:
        return f"{value} ({mode_name(value)})"
    if register is table.CURRENT_LIMIT:
        return f"{value} ({value * model.current_unit_ma:.0f} mA)"
    if register is table.VELOCITY_LIMIT:
        return f"{value} ({value * table.RAD_S_PER_VELOCITY:.2f} rad/s)"
    if register is table.RETURN_DELAY_TIME:
        return f"{value} ({2 * value} us)"
    if register is table.SHUTDOWN:
        return f"{value} ({hardware_error_names(value) or 'never'})"
    return str(value)
