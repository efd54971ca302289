"""`nodal cameras write`: the cameras that are plugged in, into the bench file."""

import argparse

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
    from nodal.bench_file import SHIPPED, bench_path  # noqa: PLC0415
    from nodal.cameras.writing import assigned, sections  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415
    from nodal.toml_file import read_table, written  # noqa: PLC0415

    path = bench_path(arguments.config)
    if path.parent == SHIPPED:
        raise CommandError(
            f"--config {arguments.config}: it comes with nodal and stays as it is; make your own with `nodal new`"
        )
    old = read_table(path).get("cameras", {})
    new = sections(assigned(arguments.camera or (), tuple(old)), arguments.mains)
    stale = {name: dict.fromkeys(old.get(name, {}).keys() - table.keys()) for name, table in new.items()}
    edit_bench_file(path, {"cameras": {name: stale[name] | table for name, table in new.items()}})
    print(written({"cameras": new}).strip().removeprefix("[cameras]").lstrip())
    for name, table in new.items():
        print(f"# which is {name}? nodal cameras look --device {table['device']}")
    return 0
