"""Which port the servos are at, and how fast they speak. Imports nothing slow, so that help stays quick."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from nodal.errors import CommandError

if TYPE_CHECKING:
    from drivers.dynamixel.bus import DynamixelBus

Buses = Callable[[int], "DynamixelBus"]
"""The bus, not yet opened, at a baud rate."""


def add_port_arguments(parser: argparse.ArgumentParser) -> None:
    """`--config` or `--port`, and `--baud`."""
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--config", metavar="BENCH", help="bench file whose servos.port it is")
    where.add_argument("--port", metavar="DEVICE", help="serial port, such as /dev/ttyUSB0")
    parser.add_argument(
        "--baud",
        type=int,
        nargs="+",
        metavar="RATE",
        help="baud rates to try (default: the bench's first, then all others)",
    )


def buses(arguments: argparse.Namespace) -> tuple[Buses, tuple[int, ...]]:
    """The bus that the arguments name, and the baud rates to try in this order; raises CommandError, BenchFileError."""
    from drivers.dynamixel.control_table import BAUD_RATES  # noqa: PLC0415

    port, first = arguments.port, 1_000_000
    if arguments.config is not None:
        from nodal.bench_file import read_bench  # noqa: PLC0415

        settings = read_bench(arguments.config).settings.servos
        port, first = settings.port, settings.baud_rate
    rates = tuple(arguments.baud or dict.fromkeys((first, *BAUD_RATES)))
    for rate in rates:
        if rate not in BAUD_RATES:
            raise CommandError(f"--baud {rate}: servos speak at {', '.join(map(str, BAUD_RATES))}")
    return buses_at(port), rates


def buses_at(port: str) -> Buses:
    """The bus at a serial port."""
    from drivers.dynamixel.bus import DynamixelBus  # noqa: PLC0415
    from drivers.dynamixel.port import SerialPort  # noqa: PLC0415

    return lambda baud_rate: DynamixelBus(SerialPort(port, baud_rate))
