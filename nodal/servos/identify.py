"""`nodal servos identify`: one servo shows itself by blinking."""

import argparse
import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING

from nodal.servos.one import add_servo_arguments, one_servo

if TYPE_CHECKING:
    from drivers.dynamixel.bus import DynamixelBus

SUMMARY = "let one servo's LED blink, so that one sees which it is; nothing moves"
HALF_PERIOD_S = 0.25


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which servo, and for how long."""
    add_servo_arguments(parser)
    parser.add_argument("--seconds", type=float, default=10.0, metavar="S", help="how long (default 10)")


def run(arguments: argparse.Namespace) -> int:
    """Blink; raises BusError, PortError, NoAnswerError, StatusError, CommandError."""
    import time  # noqa: PLC0415

    from nodal.errors import CommandError  # noqa: PLC0415

    if not 0 < arguments.seconds <= 3600:
        raise CommandError(f"--seconds {arguments.seconds:g}: allowed is more than 0, up to 3600 s")
    with one_servo(arguments) as bus:
        print(f"servo {arguments.id} blinks for {arguments.seconds:g} s", flush=True)
        blink(bus, arguments.id, arguments.seconds, time.sleep)
    return 0


def blink(bus: "DynamixelBus", servo: int, seconds: float, pause: Callable[[float], None]) -> None:
    """LED on and off; however this ends, it is off afterwards."""
    from drivers.dynamixel.control_table import LED  # noqa: PLC0415
    from drivers.dynamixel.errors import ServoError  # noqa: PLC0415

    try:
        for half in range(max(2, round(seconds / HALF_PERIOD_S))):
            bus.write(servo, LED, 1 - half % 2)
            pause(HALF_PERIOD_S)
    except BaseException:
        with contextlib.suppress(ServoError):  # what led here is to be told, not that the LED stays on
            bus.write(servo, LED, 0)
        raise
    bus.write(servo, LED, 0)
