"""`nodal new`: the folder of a bench to begin with."""

import argparse
import shlex
from pathlib import Path

Steps = tuple[tuple[str, str], ...]
"""Commands, each with what it is for."""

REAL_STEPS: Steps = (
    ("cameras list", "what is plugged in"),
    ("cameras write --config {bench}", "the cameras into the bench file, by names that last"),
    ("cameras look --config {bench} --focus --write", "where their lenses are sharpest"),
    ("cameras look --config {bench}", "what they see, and how well"),
    ("servos setup --config {bench}", "each servo, then `nodal servos check`"),
    ("calibrate board --config {bench} --out board.pdf", "the board to print"),
    ("calibrate board --config {bench} --measured MM", "how long its ruler came out"),
)
SIMULATED_STEPS: Steps = (("cameras look --config {bench}", "what the cameras see, and how well"),)
STEPS: Steps = (
    ("calibrate cameras --config {bench}", "lenses, and where the cameras stand to one another"),
    ("calibrate base --config {bench}", "where the robot stands before them"),
    ("calibrate background --config {bench}", "what they see without the robot"),
    ("calibrate robot --config {bench}", "what the servos do to the robot"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Where, and whether it is simulated."""
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="new or empty; the bench is named after it"
    )
    parser.add_argument(
        "--simulated",
        action="store_true",
        help="a simulated bench out of its box: nothing is calibrated, cameras and servos are not quite where and what they "
        "should be, one servo is wound the other way",
    )
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="which simulated bench: the same number gives the same one (default 1)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write it, and say what comes next. Raises CommandError, BenchFileError, CalibrationFileError."""
    from nodal.errors import CommandError  # noqa: PLC0415
    from nodal.new.writing import write_real, write_simulated  # noqa: PLC0415

    if arguments.seed is not None and not arguments.simulated:
        raise CommandError(f"--seed {arguments.seed}: only a bench that is --simulated is drawn by chance")
    seed = 1 if arguments.seed is None else arguments.seed
    if seed < 0:
        raise CommandError(f"--seed {seed}: it must be 0 or more")
    if arguments.simulated:
        bench, first, steps = write_simulated(arguments.folder, seed), "Next:", SIMULATED_STEPS
    else:
        bench, first, steps = (
            write_real(arguments.folder),
            "Fill in the lines marked FILL IN; next:",
            REAL_STEPS,
        )
    print(f"{bench}: a bench that is not calibrated yet. {first}")
    commands = [f"nodal {command.format(bench=shlex.quote(str(bench)))}" for command, _ in (*steps, *STEPS)]
    width = max(map(len, commands))
    for command, (_, meaning) in zip(commands, (*steps, *STEPS), strict=True):
        print(f"  {command:<{width}}  {meaning}")
    return 0
