"""The arguments of a live replay. Imports nothing slow, so that help stays quick."""

import argparse
import math

from nodal.errors import CommandError
from nodal.log.spans import add_span_arguments

ONLY_LIVE = {
    "--config": "config",
    "--topics": "topics",
    "--speed": "speed",
    "--loop": "loop",
    "--from": "from_moment",
    "--until": "until_moment",
    "--feed-controller": "feed_controller",
}
NEVER_LIVE = {"--set": "changes", "-o": "out", "--law": "law", "--jobs": "jobs", "--dask": "dask"}


def add_live_arguments(parser: argparse.ArgumentParser) -> None:
    """`--live`, and what means something only beside it."""
    parser.add_argument(
        "--live",
        action="store_true",
        help="put the recording back onto the bus, with its own spacing, for a viewer, a controller or an estimator",
    )
    parser.add_argument(
        "--config",
        metavar="BENCH",
        help="live: bench whose bus it goes to (default: the one that was recorded)",
    )
    parser.add_argument(
        "--topics",
        type=lambda text: tuple(text.split(",")),
        metavar="WORD,WORD",
        help="live: what to say; each word is a key such as shape or camera/left, who says it (sensing, controller, "
        "simulation), or all (default: sensing,simulation)",
    )
    parser.add_argument("--speed", type=_speed, metavar="X", help="live: times as fast (default 1)")
    parser.add_argument("--loop", action="store_true", help="live: begin again at the end, until Ctrl-C")
    add_span_arguments(parser)
    parser.add_argument(
        "--feed-controller",
        action="store_true",
        help="live: say recorded shapes although a controller is alive: its robot may move by them",
    )


def refuse_mixture(arguments: argparse.Namespace) -> None:
    """Raise CommandError for an argument of a live replay without `--live`, or of another replay beside it."""
    wrong, word = (NEVER_LIVE, "without") if arguments.live else (ONLY_LIVE, "beside")
    if stray := [option for option, name in wrong.items() if getattr(arguments, name)]:
        raise CommandError(f"{', '.join(stray)}: means something only {word} --live")


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not 0 < speed < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a speed: 1 is as recorded, 2 twice as fast")
    return speed
