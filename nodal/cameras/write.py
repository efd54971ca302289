"""`nodal cameras write`: the cameras that are plugged in, into the bench file."""

import argparse
import shlex
import sys

from nodal.arguments import add_config_argument

SUMMARY = "write the cameras that are plugged in into the bench file, by paths that last, with settings to begin with"
MAINS_HZ = 50


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The bench, and which camera is which."""
    add_config_argument(parser)
    parser.add_argument(
        "--camera",
        nargs="+",
        metavar="NAME=DEVICE",
        help="which device each camera is (default: the bench's cameras in the order of the devices)",
    )
    parser.add_argument(
        "--mains",
        type=int,
        choices=(50, 60),
        default=MAINS_HZ,
        help=f"frequency of the mains in Hz, which lamps flicker with (default {MAINS_HZ})",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write; raises CameraDeviceError, CommandError, BenchFileError."""
    from nodal.bench_editing import edit_bench_file  # noqa: PLC0415
    from nodal.bench_file import SHIPPED, read_bench  # noqa: PLC0415
    from nodal.cameras.writing import assigned, replacing, sections  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415
    from nodal.toml_file import read_table, written  # noqa: PLC0415

    path = read_bench(arguments.config).path
    if path.parent == SHIPPED:
        raise CommandError(
            f"--config {arguments.config}: it comes with nodal and stays as it is; make your own with `nodal new`"
        )
    old = read_table(path).get("cameras", {})
    new = sections(assigned(arguments.camera or (), tuple(old)), arguments.mains)
    edit_bench_file(
        path, {"cameras": {name: replacing(old.get(name, {}), table) for name, table in new.items()}}
    )
    print(written({"cameras": new}).strip().removeprefix("[cameras]").lstrip())
    for name, table in new.items():
        print(f"# which is {name}? nodal cameras look --device {table['device']}")
    if focused := [name for name, table in new.items() if "focus" in table["controls"]]:
        print(
            f"The focus of {' and '.join(focused)} stays where it stands now, sharp or not. With the robot in view, find it by: "
            f"nodal cameras look --config {shlex.quote(arguments.config)} --focus --write",
            file=sys.stderr,
        )
    return 0
