"""`nodal log plot`: figures of a recording for a paper."""

import argparse
import sys
from pathlib import Path

SUMMARY = "figures for a paper: nodal points and target, tracking, tendons, latency, loop, quality, path"

FORMATS = ("pdf", "svg", "png")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording, and where the figures go."""
    parser.add_argument("log", type=Path, metavar="LOG", help="a recording; its later parts belong to it")
    parser.add_argument(
        "-o", "--output", required=True, type=Path, metavar="DIR", help="folder; it must not exist yet"
    )
    parser.add_argument(
        "--format",
        dest="formats",
        nargs="+",
        choices=FORMATS,
        default=["pdf", "png"],
        help="file formats of each figure (default: pdf png)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Draw what the recording holds; figures are said on stdout, what was left out and why on stderr."""
    from nodal.errors import ReportError  # noqa: PLC0415
    from nodal.exports.output import draft_of, new_folder  # noqa: PLC0415
    from nodal.exports.plots.drawing import draw_figures  # noqa: PLC0415
    from nodal.report.findings import Findings  # noqa: PLC0415
    from nodal.report.loading import load_run  # noqa: PLC0415
    from recordings.log import Log  # noqa: PLC0415

    draft_of(arguments.output)
    log = Log(arguments.log)
    findings = Findings(load_run(log))
    with new_folder(arguments.output) as folder:
        written, left_out = draw_figures(findings, folder, dict.fromkeys(arguments.formats))
        if not written:
            raise ReportError(f"{log.path}: it holds nothing that a figure could show")
    for name, needs in left_out.items():
        print(f"nodal: warning: no figure {name}: the recording holds too little of {needs}", file=sys.stderr)
    for damage in log.damage:
        print(f"nodal: warning: {damage}", file=sys.stderr)
    for file in written:
        print(arguments.output / file.name)
    return 0
