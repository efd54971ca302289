"""`nodal servos setup`: the servos become what the bench file says."""

import argparse

from nodal.arguments import add_config_argument
from nodal.exit_status import refused

SUMMARY = "write ids, baud rate, delays, limits and mode of a bench's servos, as far as they differ"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which axes, and what is allowed."""
    add_config_argument(parser)
    parser.add_argument("--axis", metavar="NAME", help="only the servo of this axis (default: all)")
    parser.add_argument(
        "--from-id", type=int, metavar="ID", help="the id that this axis' servo has so far; a new one has 1"
    )
    parser.add_argument("--dry-run", action="store_true", help="say what would change, and write nothing")
    parser.add_argument(
        "--relax", action="store_true", help="turn torque off where it is on; what the servo holds is let go"
    )


def run(arguments: argparse.Namespace) -> int:
    """Say each change; 0 when all is as it should be, 3 when it is refused. Raises CommandError, BusError, ServoError."""
    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.errors import CommandError, SetupRefusedError  # noqa: PLC0415
    from nodal.servos.port import buses_at  # noqa: PLC0415
    from nodal.servos.setting_up import Order, set_up  # noqa: PLC0415

    if arguments.from_id is not None and arguments.axis is None:
        raise CommandError(f"--from-id {arguments.from_id}: say with --axis which axis this servo becomes")
    order = Order(
        settings=read_bench(arguments.config).settings.servos,
        axis=arguments.axis,
        from_id=arguments.from_id,
        relax=arguments.relax,
        dry_run=arguments.dry_run,
    )
    changes = 0
    try:
        for change in set_up(buses_at(order.settings.port), order):
            print(change, flush=True)
            changes += 1
    except SetupRefusedError as refusal:
        return refused(refusal)
    print(f"{changes} to change, nothing written" if order.dry_run else f"{changes} changed")
    return 0
