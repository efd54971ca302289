"""What the arguments of `nodal target` look like. Imports nothing slow, so that help stays quick."""

import argparse
import re
from collections.abc import Callable, Sequence
from typing import Any

TIMINGS = ("minimum-jerk", "trapezoid")
_FORMS = {1: "NUMBER", 2: "X,Y", 3: "X,Y,Z"}


def add_kind(kinds: Any, name: str, summary: str, example: str) -> argparse.ArgumentParser:
    """The parser of one kind of target, with what all kinds can be asked."""
    parser: argparse.ArgumentParser = kinds.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}. Positions are in mm in the robot frame.",
        epilog=f"For example: nodal target --config BENCH {name} {example}",
    )
    # argparse takes -5,0,85 for an option unless it is told what numbers look like here
    parser._negative_number_matcher = re.compile(r"-[\d.]")  # noqa: SLF001
    parser.add_argument(
        "--plan",
        action=argparse.BooleanOptionalAction,
        help="lead the whole body to the target on a way that is planned; without either, that is done where the straight "
        "way comes too near to a forbidden region",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--check", action="store_true", help="only say whether it can be reached, by the bench file alone"
    )
    what.add_argument(
        "--wait", action="store_true", help="say how far it has come, until it has arrived (0) or failed (3)"
    )
    return parser


def add_pace(parser: argparse.ArgumentParser, otherwise: str = "") -> None:
    """How fast; `otherwise` says what happens without."""
    fast = parser.add_mutually_exclusive_group()
    fast.add_argument("--duration", type=float, metavar="S", help=otherwise or "how long it takes")
    fast.add_argument(
        "--speed",
        type=float,
        metavar="MM_S",
        help="the highest; default half of what the bench file allows, or less",
    )
    parser.add_argument("--timing", choices=TIMINGS, default=TIMINGS[0], help=f"default {TIMINGS[0]}")
    parser.add_argument("--acceleration", type=float, metavar="MM_S2", help="of the timing trapezoid")


def add_weight(parser: argparse.ArgumentParser) -> None:
    """How much each point counts."""
    parser.add_argument(
        "--weight",
        action="append",
        default=[],
        type=named(1),
        metavar="NAME=W",
        help="how much a point counts (default 1); 0 only watches it",
    )


def named(count: int) -> Callable[[str], tuple[str, Sequence[float]]]:
    """NAME=... with so many numbers."""

    def parsed(text: str) -> tuple[str, Sequence[float]]:
        name, equals, values = text.rpartition("=")
        if not equals or not name:
            raise argparse.ArgumentTypeError(f"{text!r} is not NAME={_FORMS[count]}")
        return name, numbers(count)(values)

    return parsed


def numbers(count: int) -> Callable[[str], list[float]]:
    """So many numbers with commas between them."""

    def parsed(text: str) -> list[float]:
        try:
            values = [float(value) for value in text.split(",")]
        except ValueError:
            values = []
        if len(values) != count:
            raise argparse.ArgumentTypeError(f"{text!r} is not {count} numbers with commas between them")
        return values

    return parsed
