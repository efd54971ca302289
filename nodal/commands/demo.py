"""`nodal demo`: the whole simulated bench, in closed loop, with a report at the end."""

import argparse
from pathlib import Path

DURATION_S = 60.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which bench, how long, where to, and how to answer."""
    parser.add_argument(
        "--config",
        default="simulated",
        metavar="BENCH",
        help="bench file of a simulated bench, or the name of one that comes with nodal (default: simulated)",
    )
    parser.add_argument(
        "--duration",
        type=float,
        default=DURATION_S,
        metavar="S",
        help=f"seconds in closed loop, homing aside (default {DURATION_S:g})",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder for recording, summary and pictures (default runs/TIME-demo)",
    )
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """Run the demo; Ctrl-C ends it early, with a report of what there was."""
    from nodal.demo.performance import perform  # noqa: PLC0415

    return perform(arguments.config, arguments.duration, arguments.out, as_json=arguments.json)
