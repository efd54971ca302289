"""`nodal servos list`: who answers on the bus."""

import argparse

from nodal.servos.port import add_port_arguments, buses

SUMMARY = "who answers on the bus: id, model, firmware, baud rate, mode, voltage, temperature, errors"
MAX_ID = 252


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Where to look."""
    add_port_arguments(parser)
    parser.add_argument(
        "--ids", type=_ids, default=range(MAX_ID + 1), metavar="A-B", help="ids to ask (default 0-252)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print each servo as it is found; raises BusError when there is none, PortError."""
    from nodal.errors import BusError  # noqa: PLC0415
    from nodal.servos import words  # noqa: PLC0415
    from nodal.servos.scan import scan  # noqa: PLC0415

    bus_at, rates = buses(arguments)
    found = 0
    for servo in scan(bus_at, rates, arguments.ids):
        if not found:
            print(words.line(words.HEADER))
        print(words.row(servo), flush=True)
        found += 1
    if not found:
        raise BusError(
            f"{bus_at(rates[0]).port}: nobody answers at {', '.join(map(str, rates))} baud, ids {arguments.ids[0]} to "
            f"{arguments.ids[-1]}; is the bus powered and plugged in?"
        )
    return 0


def _ids(text: str) -> range:
    first, dash, last = text.partition("-")
    try:
        ids = range(int(first), int(last if dash else first) + 1)
    except ValueError:
        ids = range(0)
    if not ids or ids[0] < 0 or ids[-1] > MAX_ID:
        raise argparse.ArgumentTypeError(f"{text!r} is not A-B within 0 to {MAX_ID}")
    return ids
