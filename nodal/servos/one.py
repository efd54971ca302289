"""One servo, named by its id, at whatever baud rate it is found. Imports nothing slow, so that help stays quick."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from nodal.servos.port import add_port_arguments, buses

if TYPE_CHECKING:
    from drivers.dynamixel.bus import DynamixelBus


def add_servo_arguments(parser: argparse.ArgumentParser) -> None:
    """The id, and where to look for it."""
    parser.add_argument("id", type=int, metavar="ID", help="the servo's id, 0 to 252")
    add_port_arguments(parser)


@contextmanager
def one_servo(arguments: argparse.Namespace) -> Iterator["DynamixelBus"]:
    """The bus, opened at the servo's baud rate; raises CommandError, BusError and PortError."""
    from nodal.errors import BusError, CommandError  # noqa: PLC0415
    from nodal.servos.scan import EVERY_ID, find  # noqa: PLC0415
    from nodal.servos.words import SHARED  # noqa: PLC0415

    if arguments.id not in EVERY_ID:
        raise CommandError(f"id {arguments.id}: servos have ids 0 to {EVERY_ID[-1]}")
    bus_at, rates = buses(arguments)
    found = find(bus_at, rates, [arguments.id])
    if not found:
        raise BusError(
            f"{bus_at(rates[0]).port}: servo {arguments.id} does not answer at {', '.join(map(str, rates))} baud"
        )
    if not found[0].alone:
        raise BusError(f"servo {arguments.id}: {SHARED}")
    with bus_at(found[0].baud_rate) as bus:
        yield bus
