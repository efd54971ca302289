"""`nodal calibrate cameras`: from views of a board to cameras whose lenses and places among one another are known."""

import argparse

from nodal.arguments import add_config_argument
from nodal.cameras.chosen import add_source_arguments
from nodal.exit_status import refused

SUMMARY = "show the board to the cameras; finds their lenses and where they stand among one another"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which views, and how many."""
    add_config_argument(parser)
    add_source_arguments(parser)
    parser.add_argument(
        "--views", type=int, metavar="N", help="end with so many views (default: when nothing is missing)"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """0, or 3 with what is missing, and nothing is overwritten then. Raises BenchFileError, CommandError, CameraError, BoardError."""
    import json  # noqa: PLC0415

    from calibration.errors import ViewsError  # noqa: PLC0415
    from nodal.calibrate.cameras.calibrating import calibrate_cameras  # noqa: PLC0415
    from nodal.calibrate.cameras.outcome import as_builtins, as_text  # noqa: PLC0415
    from nodal.errors import CalibrationError, CommandError  # noqa: PLC0415

    if arguments.views is not None and arguments.views < 1:
        raise CommandError(f"--views {arguments.views}: allowed is 1 or more")
    try:
        outcome = calibrate_cameras(arguments)
    except (CalibrationError, ViewsError) as refusal:
        return refused(f"{refusal}\nnothing was changed")
    print(json.dumps(as_builtins(outcome)) if arguments.json else as_text(outcome))
    return 0
