"""`nodal nodes`: name other nodal points while sensing runs, by their distance from the base along the centreline."""

import argparse

from nodal.arguments import add_config_argument, add_timeout_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The points, from the base to the tip."""
    parser.add_argument(
        "nodes", nargs="+", type=_node, metavar="NAME=MM", help="in order from the base: middle=40 tip=80"
    )
    add_config_argument(parser)
    add_timeout_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Ask sensing; 0 when it accepts, 3 when it refuses."""
    import numpy as np  # noqa: PLC0415

    from messaging.shape import NodalPoints  # noqa: PLC0415
    from messaging.topics import SENSING_NODES  # noqa: PLC0415
    from nodal.asking import ask  # noqa: PLC0415

    names, distances = zip(*arguments.nodes, strict=True)
    return ask(
        arguments.config,
        SENSING_NODES,
        NodalPoints(names=names, arc_mm=np.array(distances)),
        arguments.timeout,
    )


def _node(text: str) -> tuple[str, float]:
    name, _, distance = text.rpartition("=")
    try:
        return name, float(distance)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=MM") from None
