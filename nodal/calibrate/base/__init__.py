"""`nodal calibrate base`: where the robot stands among the cameras, by a board at its base or by the robot itself."""

import argparse

from nodal.arguments import add_config_argument
from nodal.cameras.chosen import add_source_arguments
from nodal.exit_status import REFUSED, refused

SUMMARY = "find the robot frame, by a board in a fixture at the base or by the robot itself"
LONGEST_PULL_MM = 20.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which way, and how."""
    add_config_argument(parser)
    parser.add_argument(
        "--board",
        action="store_true",
        help="by the board in its fixture at the base, the default where the bench file has [board.at_base]",
    )
    parser.add_argument(
        "--robot",
        action="store_true",
        help="by the robot, the default elsewhere: it moves! Each tendon is pulled, then the stage goes up and back again; "
        "with --board both are done and compared, and the rig is written by the board",
    )
    parser.add_argument(
        "--pull",
        type=float,
        default=2.0,
        metavar="MM",
        help="how far each tendon or pair is pulled, for --robot (default 2)",
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")
    add_source_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """0, or 3 with the reason when the frame cannot be found or sensing is not content with it. Raises NodalError."""
    import json  # noqa: PLC0415
    import sys  # noqa: PLC0415

    from calibration.errors import BasePosesError, ViewsError  # noqa: PLC0415
    from nodal.calibrate.base.finding import find_base  # noqa: PLC0415
    from nodal.calibrate.base.words import as_builtins, as_text, warnings  # noqa: PLC0415
    from nodal.calibrate.ending import next_step, report_anew  # noqa: PLC0415
    from nodal.errors import CalibrationError, CommandError, RobotStoppedError  # noqa: PLC0415

    if not 0 < arguments.pull <= LONGEST_PULL_MM:
        raise CommandError(
            f"--pull {arguments.pull:g} mm: allowed is above 0 and up to {LONGEST_PULL_MM:g} mm"
        )
    try:
        outcome = find_base(arguments)
    except (CalibrationError, RobotStoppedError, BasePosesError, ViewsError) as refusal:
        return refused(refusal, refusal.advice if isinstance(refusal, RobotStoppedError) else "")
    print(json.dumps(as_builtins(outcome)) if arguments.json else as_text(outcome))
    for warning in warnings(outcome):
        print(f"warning: {warning}", file=sys.stderr)
    print(f"report:  {report_anew(outcome.bench)}", file=sys.stderr)
    if outcome.check is not None and not outcome.check.good:
        return REFUSED
    print(next_step(outcome.bench, "base"), file=sys.stderr)
    return 0
