"""`nodal estimate`: the robot's shape from still images, for people without a running bench."""

import argparse
from pathlib import Path

from nodal.exit_status import REFUSED

METHODS = "refined", "plain"
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
        "--colour",
        type=_colour,
        metavar="R,G,B",
        help="the backdrop's colour, each 0 to 255, for cameras without --background",
    )
    parser.add_argument(
        "--threshold",
        type=float,
        metavar="T",
        help="colour distance in levels above which a pixel is robot; without it, it follows from noise and contrast",
    )
    parser.add_argument(
        "--work-area",
        action="append",
        default=[],
        type=_named_corners,
        metavar="NAME=X,Y;X,Y;...",
        help="corners of a polygon in px; outside of it that camera shows no robot",
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help="refined: a tube fitted to the edges in all pictures at once; plain: the paper's steps (default refined)",
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
    from nodal import still, still_words  # noqa: PLC0415
    from sensing.settings import MethodName  # noqa: PLC0415

    question = still.Question(
        calibration=arguments.calibration,
        images=dict(arguments.image),
        backgrounds=dict(arguments.background),
        nodes_mm=arguments.nodes,
        length_mm=arguments.length,
        method=MethodName(arguments.method),
        colour_rgb=arguments.colour,
        threshold=arguments.threshold,
        work_areas=dict(arguments.work_area),
    )
    answer = still.answer(question)
    if arguments.figures:
        still.draw(question, answer, arguments.figures)
    print(still_words.as_json(answer) if arguments.json else still_words.as_text(answer))
    return REFUSED if isinstance(answer, still.Refusal) else 0


def _named(text: str, example: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise argparse.ArgumentTypeError(f"{text!r} is not {example}")
    return name, value


def _named_file(text: str) -> tuple[str, Path]:
    name, file = _named(text, "NAME=FILE, such as left=left.jpg")
    return name, Path(file)


def _named_corners(text: str) -> tuple[str, tuple[tuple[float, float], ...]]:
    example = "NAME=X,Y;X,Y;..., such as left=600,200;1300,200;1300,1000;600,1000"
    name, corners = _named(text, example)
    numbers = [_numbers(corner) for corner in corners.split(";")]
    if not all(len(corner) == 2 for corner in numbers):
        raise argparse.ArgumentTypeError(f"{text!r} is not {example}")
    return name, tuple((corner[0], corner[1]) for corner in numbers)


def _colour(text: str) -> tuple[float, ...]:
    levels = _numbers(text)
    if len(levels) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is not R,G,B, such as 60,140,75")
    return levels


def _distances(text: str) -> tuple[float, ...]:
    if distances := _numbers(text):
        return distances
    raise argparse.ArgumentTypeError(f"{text!r} is not a list of distances in mm, such as 10,20,40,80")


def _numbers(text: str) -> tuple[float, ...]:
    """The numbers between commas; none at all when one of them is not a number."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        return ()
