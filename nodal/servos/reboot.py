"""`nodal servos reboot`: a servo that has shut down is made usable again."""

import argparse

from nodal.exit_status import REFUSED
from nodal.servos.one import add_servo_arguments, one_servo

SUMMARY = "restart one servo that has shut down by a hardware error; it comes back relaxed, without its turns"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which servo."""
    add_servo_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Restart it; 3 when it reports an error all the same. Raises BusError, PortError, NoAnswerError, StatusError."""
    from drivers.dynamixel.control_table import HARDWARE_ERROR_STATUS, hardware_error_names  # noqa: PLC0415

    with one_servo(arguments) as bus:
        bus.reboot(arguments.id)
        bits = bus.read(arguments.id, HARDWARE_ERROR_STATUS)
    print(f"servo {arguments.id} restarted; hardware error: {hardware_error_names(bits) or 'none'}")
    return REFUSED if bits else 0
