"""`nodal estimate`: the robot's shape from still images, for people without a running bench."""

import argparse
from pathlib import Path

REFUSED = 3
DEFAULT_NODES_MM = (10.0, 20.0, 40.0, 80.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The rig, one image for each camera, and what to report."""
    parser.add_argument(
        "--calibration",
        required=True,
        type=Path,
        metavar="RIG",
        help="calibration file of the cameras (JSON)",
    )
    parser.add_argument(
        "--image",
        action="append",
        required=True,
        type=_named_file,
        metavar="NAME=FILE",
        help="a camera's picture; given for two cameras or more",
    )
    parser.add_argument(
        "--background",
        action="append",
        default=[],
        type=_named_file,
        metavar="NAME=FILE",
        help="the same camera's picture without the robot; without it the backdrop is fitted to the image itself",
    )
    parser.add_argument(
        "--nodes",
        type=_distances,
        default=DEFAULT_NODES_MM,
        metavar="MM,MM,...",
        help="nodal points by their distance from the base (default 10,20,40,80)",
    )
    parser.add_argument("--length", type=float, metavar="MM", help="the robot's length, where it is known")
    parser.add_argument(
        "--figures",
        type=Path,
        metavar="DIR",
        help="write pictures that explain the estimate, or its refusal, here (PNG and PDF; needs the extra `plots`)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")


def run(arguments: argparse.Namespace) -> int:
    """Estimate and print; 0 with a shape, 3 with the reason why there is none."""
    from nodal import still  # noqa: PLC0415

    question = still.Question(
        calibration=arguments.calibration,
        images=dict(arguments.image),
        backgrounds=dict(arguments.background),
        nodes_mm=arguments.nodes,
        length_mm=arguments.length,
    )
    answer = still.answer(question)
    if arguments.figures:
        still.draw(question, answer, arguments.figures)
    print(still.as_json(answer) if arguments.json else still.as_text(answer))
    return REFUSED if isinstance(answer, still.Refusal) else 0


def _named_file(text: str) -> tuple[str, Path]:
    name, equals, file = text.partition("=")
    if not (name and equals and file):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=FILE, such as left=left.jpg")
    return name, Path(file)


def _distances(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a list of distances in mm, such as 10,20,40,80"
        ) from None
