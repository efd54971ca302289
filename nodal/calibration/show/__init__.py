"""`nodal calibration show`: a calibration in words."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from nodal.calibration.convert import add_reading_arguments, choices_of
from nodal.calibration.formats.names import FORMATS

if TYPE_CHECKING:
    from nodal.bench_file import BenchFile
    from nodal.calibration.formats.calibration import Calibration

SUMMARY = "say what a calibration holds: lenses, places, angles, and what accuracy to expect"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A file, or a bench."""
    parser.add_argument(
        "files",
        nargs="*",
        type=Path,
        metavar="FILE",
        help="a calibration in any format that `nodal calibration convert` reads",
    )
    parser.add_argument(
        "--config", metavar="BENCH", help="the calibration of this bench, instead of a file's"
    )
    parser.add_argument("--from", dest="source_format", choices=FORMATS, help="format of FILE")
    add_reading_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Print it. Raises BenchFileError, CalibrationFileError, CommandError."""
    import msgspec  # noqa: PLC0415

    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.calibration.formats.reading import read_calibration  # noqa: PLC0415
    from nodal.calibration.show.figures import figures  # noqa: PLC0415
    from nodal.calibration.show.words import words  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415

    if bool(arguments.files) == bool(arguments.config):
        raise CommandError("say which calibration: a FILE, or --config BENCH")
    if arguments.config:
        bench = read_bench(arguments.config)
        found = figures(of_bench(bench), bench.settings.robot.length_mm)
    else:
        found = figures(read_calibration(arguments.files, arguments.source_format, choices_of(arguments)))
    print(msgspec.json.encode(found).decode() if arguments.json else "\n".join(words(found)))
    return 0


def of_bench(bench: "BenchFile") -> "Calibration":
    """What sensing uses, with what is known of its exactness; before the robot frame is found, the cameras alone."""
    from dataclasses import replace  # noqa: PLC0415

    from nodal.calibration.folder import load_cameras  # noqa: PLC0415
    from nodal.calibration.formats import own  # noqa: PLC0415
    from nodal.calibration.formats.calibration import Calibration, Choices  # noqa: PLC0415

    cameras, rig_file = load_cameras(bench), Path(bench.settings.calibration)
    if not rig_file.exists():
        return Calibration(cameras=cameras)
    rig = own.read([rig_file], Choices())
    same = [one.intrinsics for one in cameras.cameras] == [one.intrinsics for one in rig.cameras.cameras]
    return replace(rig, cameras=cameras) if same else rig
