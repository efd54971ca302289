"""`nodal servos check`: whether the servos are what the bench file says."""

import argparse

from nodal.arguments import add_config_argument
from nodal.exit_status import REFUSED

SUMMARY = "compare every servo with the bench file, and say what to do about each difference"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The bench."""
    add_config_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """0 when all is as it should be, 3 when something is not. Raises BenchFileError, PortError, NoAnswerError."""
    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.servos.findings import examine  # noqa: PLC0415
    from nodal.servos.port import buses_at  # noqa: PLC0415

    settings = read_bench(arguments.config).settings.servos
    different = False
    for finding in examine(buses_at(settings.port), settings):
        print(finding, flush=True)
        different = True
    if different:
        return REFUSED
    print(
        f"{len(settings.axes)} servos at {settings.port}, {settings.baud_rate} baud: as the bench file says"
    )
    return 0
