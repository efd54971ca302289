"""`nodal target`: where nodal points should go. The controller checks the target and answers before anything moves."""

import argparse
from collections.abc import Callable
from pathlib import Path

from nodal.arguments import add_config_argument, add_timeout_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """`point`, `circle` and `file`."""
    add_config_argument(parser)
    add_timeout_argument(parser)
    kinds = parser.add_subparsers(required=True, metavar="KIND")

    point = kinds.add_parser("point", help="hold nodal points at places: tip=10,0,75 middle=5,0,40")
    point.add_argument("places", nargs="+", type=_named(3), metavar="NAME=X,Y,Z")
    _add_weight(point)
    point.set_defaults(target=_points)

    circle = kinds.add_parser("circle", help="lead one nodal point round a level circle")
    circle.add_argument("node", metavar="NAME")
    circle.add_argument("--radius", type=float, default=15.0, metavar="MM", help="default 15")
    circle.add_argument("--period", type=float, default=10.0, metavar="S", help="default 10")
    circle.add_argument("--height", type=float, default=70.0, metavar="MM", help="default 70")
    circle.add_argument("--centre", type=_numbers(2), default=[0.0, 0.0], metavar="X,Y", help="default 0,0")
    circle.set_defaults(target=_circle)

    path = kinds.add_parser(
        "file", help="a path from a CSV file: time_s,NAME.x,NAME.y,NAME.z,... in s and mm"
    )
    path.add_argument("file", type=Path, metavar="CSV")
    path.add_argument("--repeat", action="store_true", help="begin again when the end is reached")
    _add_weight(path)
    path.set_defaults(target=_path)


def run(arguments: argparse.Namespace) -> int:
    """Ask the controller to follow the target; 0 when it accepts, 3 when it refuses."""
    from messaging.topics import CONTROLLER_TARGET  # noqa: PLC0415
    from nodal.asking import ask  # noqa: PLC0415

    return ask(arguments.config, CONTROLLER_TARGET, arguments.target(arguments), arguments.timeout)


def _points(arguments: argparse.Namespace) -> object:
    from nodal import targets  # noqa: PLC0415

    return targets.points(dict(arguments.places), _weights(arguments))


def _circle(arguments: argparse.Namespace) -> object:
    from nodal import targets  # noqa: PLC0415

    return targets.circle(
        arguments.node,
        radius_mm=arguments.radius,
        period_s=arguments.period,
        height_mm=arguments.height,
        centre_mm=tuple(arguments.centre),
    )


def _path(arguments: argparse.Namespace) -> object:
    from nodal import targets  # noqa: PLC0415

    return targets.path(arguments.file, _weights(arguments), repeat=arguments.repeat)


def _add_weight(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--weight",
        action="append",
        default=[],
        type=_named(1),
        metavar="NAME=W",
        help="how much a point counts (default 1); 0 only watches it",
    )


def _weights(arguments: argparse.Namespace) -> dict[str, float]:
    return {name: weight for name, (weight,) in arguments.weight}


def _named(count: int) -> Callable[[str], tuple[str, list[float]]]:
    def named(text: str) -> tuple[str, list[float]]:
        name, equals, values = text.rpartition("=")
        if not equals or not name:
            raise argparse.ArgumentTypeError(f"{text!r} is not NAME={'X,Y,Z' if count == 3 else 'NUMBER'}")
        return name, _numbers(count)(values)

    return named


def _numbers(count: int) -> Callable[[str], list[float]]:
    def numbers(text: str) -> list[float]:
        try:
            values = [float(value) for value in text.split(",")]
        except ValueError:
            values = []
        if len(values) != count:
            raise argparse.ArgumentTypeError(f"{text!r} is not {count} numbers with commas between them")
        return values

    return numbers
