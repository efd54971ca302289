"""`nodal calibrate background`: what the cameras see without the robot, and whether the robot will stand out from it."""

import argparse

from nodal.arguments import add_config_argument
from nodal.cameras.chosen import add_source_arguments
from nodal.exit_status import REFUSED, refused

SUMMARY = "take the pictures without the robot; judges light, glare and backdrop, finds the work area"
PICTURES = 30


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The bench, the pictures, and how many."""
    add_config_argument(parser)
    add_source_arguments(parser)
    parser.add_argument(
        "--pictures",
        type=int,
        default=PICTURES,
        metavar="N",
        help=f"pictures of each camera to take the mean of (default {PICTURES})",
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """0; 3 when the scene is not empty, and nothing is written then, or when sensing does not see the robot before it.

    Raises BenchFileError, CalibrationFileError, CommandError, CameraError.
    """
    import sys  # noqa: PLC0415

    import msgspec  # noqa: PLC0415

    from nodal.calibrate.background.taking import calibrate_background  # noqa: PLC0415
    from nodal.calibrate.background.words import words  # noqa: PLC0415
    from nodal.calibrate.ending import next_step, report_anew  # noqa: PLC0415
    from nodal.errors import CalibrationError, CommandError  # noqa: PLC0415

    if arguments.pictures < 1:
        raise CommandError(f"--pictures {arguments.pictures}: allowed is 1 or more")
    try:
        outcome = calibrate_background(arguments)
    except CalibrationError as refusal:
        return refused(refusal)
    found = outcome.found
    print(
        msgspec.json.encode(found).decode()
        if arguments.json
        else "\n".join(words(found.cameras, found.robot))
    )
    print(f"written {', '.join(map(str, outcome.files))}, and into {outcome.bench.path}", file=sys.stderr)
    print(f"report:  {report_anew(outcome.bench)}", file=sys.stderr)
    if found.robot is not None and not found.robot.fine:
        return REFUSED
    print(next_step(outcome.bench, "background"), file=sys.stderr)
    return 0
