"""`nodal calibration report`: one page on what was calibrated."""

import argparse
from pathlib import Path

from nodal.arguments import add_config_argument

SUMMARY = "one HTML page with pictures of what was calibrated, and how good it is (needs the extra `plots`)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which bench, and where the page goes."""
    add_config_argument(parser)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="the page (default: report.html in the folder of the calibration)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write the page and print its path; raises BenchFileError, CalibrationFileError, ReportError."""
    from nodal.calibrate.report.page import write_report  # noqa: PLC0415
    from nodal.calibration.folder import own_bench  # noqa: PLC0415

    print(write_report(own_bench(arguments.config), arguments.out))
    return 0
