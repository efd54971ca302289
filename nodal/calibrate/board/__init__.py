"""`nodal calibrate board`: the board on paper, and how large it came out of the printer."""

import argparse
from pathlib import Path

from nodal.arguments import add_config_argument
from nodal.exit_status import refused

SUMMARY = "make the board's printable page, true to scale; then tell how long its ruler came out"
PAPERS = ("A4", "A3", "letter")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Where the page goes, or what was measured on it."""
    add_config_argument(parser)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--out",
        type=_drawable,
        metavar="FILE",
        help="write the page here: .pdf or .svg (needs the extra `plots`)",
    )
    what.add_argument(
        "--measured",
        type=float,
        metavar="MM",
        help="length of the printed ruler; square_mm and marker_mm in the bench file become what was really printed",
    )
    parser.add_argument("--paper", choices=PAPERS, default=PAPERS[0], help="the sheet (default A4)")


def run(arguments: argparse.Namespace) -> int:
    """0, or 3 with what would fit; raises BenchFileError, CommandError, BoardError, CalibrationFileError."""
    from nodal.calibrate.board.printing import correct_board, print_board  # noqa: PLC0415
    from nodal.calibration.folder import own_bench  # noqa: PLC0415
    from nodal.errors import CalibrationError  # noqa: PLC0415

    bench = own_bench(arguments.config)
    try:
        if arguments.out is None:
            print(correct_board(bench, arguments.measured))
        else:
            print(print_board(bench, arguments.out, arguments.paper))
    except CalibrationError as refusal:
        return refused(refusal)
    return 0


def _drawable(text: str) -> Path:
    if Path(text).suffix.lower() not in (".pdf", ".svg"):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .pdf or .svg")
    return Path(text)
