"""`nodal calibration convert`: calibrations from and to OpenCV, ROS, Kalibr and MATLAB."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from nodal.calibration.formats.names import CAMERAS, FORMATS, UNITS_MM

if TYPE_CHECKING:
    from nodal.calibration.formats.calibration import Choices

SUMMARY = "bring a calibration from or to OpenCV, ROS, Kalibr or MATLAB"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Files, formats, and what files do not say themselves."""
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="IN",
        help="calibration file; several where a format has one for each camera",
    )
    parser.add_argument(
        "out",
        type=Path,
        metavar="OUT",
        help="file to write; a folder for ros, one file in it for each camera",
    )
    parser.add_argument(
        "--from",
        dest="source_format",
        choices=FORMATS,
        help="format of IN (default: seen from what is in it)",
    )
    parser.add_argument(
        "--to",
        dest="target_format",
        choices=FORMATS,
        help="format of OUT; .json, .xml and .mat need none: .json is a rig where the robot frame is known, else cameras",
    )
    add_reading_arguments(parser)
    parser.add_argument(
        "--drop-k3", action="store_true", help="leave k3 out where a format cannot hold it (kalibr)"
    )


def add_reading_arguments(parser: argparse.ArgumentParser) -> None:
    """What a calibration file may not say itself."""
    parser.add_argument(
        "--names",
        type=lambda text: tuple(text.split(",")),
        default=(),
        metavar="NAME,NAME",
        help="what the bench file calls the cameras, in the order of IN",
    )
    parser.add_argument(
        "--units",
        choices=tuple(UNITS_MM),
        help="unit of lengths in files that do not say it (OpenCV: mm unless given); kalibr and ros are always in m",
    )
    parser.add_argument(
        "--size", type=_size, metavar="WxH", help="size of the pictures, for OpenCV files without it"
    )
    parser.add_argument(
        "--poses",
        type=Path,
        metavar="FILE",
        help="a calibration that says where the cameras stand, when IN does not (one camera a file)",
    )


def choices_of(arguments: argparse.Namespace, *, drop_k3: bool = False) -> "Choices":
    """What was said on the command line; raises CalibrationFileError."""
    from nodal.calibration.formats.calibration import Choices  # noqa: PLC0415
    from nodal.calibration.formats.reading import read_calibration  # noqa: PLC0415

    poses = arguments.poses and read_calibration([arguments.poses], None, Choices()).cameras
    return Choices(
        names=arguments.names,
        mm_per_unit=UNITS_MM.get(arguments.units),
        size_px=arguments.size,
        poses=poses,
        drop_k3=drop_k3,
    )


def run(arguments: argparse.Namespace) -> int:
    """Read, write, and say what was assumed and what was left out. Raises CalibrationFileError, CommandError."""
    from dataclasses import replace  # noqa: PLC0415

    from nodal.calibration.formats.reading import read_calibration, write_calibration  # noqa: PLC0415

    choices = choices_of(arguments, drop_k3=arguments.drop_k3)
    calibration = read_calibration(arguments.files, arguments.source_format, choices)
    names = ", ".join(
        f"{camera.name} {camera.width_px}x{camera.height_px}" for camera in calibration.cameras.cameras
    )
    print(f"read {', '.join(map(str, arguments.files))}: {names}")
    for note in calibration.notes:
        print(f"  {note}")
    form, written = write_calibration(
        arguments.out, arguments.target_format, replace(calibration, notes=()), choices
    )
    print(f"written {arguments.out} ({form})")
    for note in written.notes:
        print(f"  {note}")
    if form == CAMERAS:
        print("the robot frame is not in it: go on with `nodal calibrate base`", file=sys.stderr)
    return 0


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    try:
        return int(width), int(height)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not WxH, such as 1920x1080") from error
