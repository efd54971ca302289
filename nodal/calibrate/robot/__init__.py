"""`nodal calibrate robot`: what the tendons truly do to the robot."""

import argparse

from nodal.arguments import add_config_argument
from nodal.exit_status import refused

SUMMARY = "move each tendon gently and identify signs, gains, coupling and lost motion"
SHARE, LEAST_SHARE = 0.6, 0.2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The bench, how far, and what is printed."""
    add_config_argument(parser)
    parser.add_argument(
        "--share",
        type=float,
        default=SHARE,
        metavar="SHARE",
        help="how far tendons are moved, as a share of controller.limits.displacement_mm (default %(default)s)",
    )
    parser.add_argument("--dry-run", action="store_true", help="say what would be moved, and move nothing")
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """0, or 3 with the reason when the robot cannot be led, is not wired as it is drawn, or what came out is not to be
    believed. Raises NodalError.
    """
    import sys  # noqa: PLC0415

    from calibration.errors import RobotPosesError  # noqa: PLC0415
    from nodal.calibrate.ending import next_step, report_anew  # noqa: PLC0415
    from nodal.calibrate.robot.calibrating import calibrate_robot, foretold  # noqa: PLC0415
    from nodal.calibrate.robot.words import as_json, as_text  # noqa: PLC0415
    from nodal.calibration.folder import own_bench  # noqa: PLC0415
    from nodal.errors import CalibrationError, CommandError, RobotStoppedError  # noqa: PLC0415

    if not LEAST_SHARE <= arguments.share <= 1:
        raise CommandError(
            f"--share {arguments.share:g}: allowed are {LEAST_SHARE:g} to 1; in smaller moves lost motion hides the rest"
        )
    if arguments.dry_run and arguments.json:
        raise CommandError("--dry-run says in words what would be moved; leave --json out")
    if arguments.dry_run:
        print(foretold(arguments.config, arguments.share))
        return 0
    try:
        bench = own_bench(arguments.config)
        found = calibrate_robot(bench, arguments.share)
    except (RobotStoppedError, RobotPosesError, CalibrationError) as refusal:
        return refused(refusal, refusal.advice if isinstance(refusal, RobotStoppedError) else "")
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        raise
    print(as_json(found) if arguments.json else as_text(found))
    print(f"report:  {report_anew(bench)}", file=sys.stderr)
    if found.doubt:
        return refused(f"{found.doubt}; [controller.identified] stays as it was")
    print(next_step(bench, "robot"), file=sys.stderr)
    return 0
