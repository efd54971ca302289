"""`nodal log recover`: one whole file, with its index, out of everything in a recording that can be read."""

import argparse
import sys
from pathlib import Path

SUMMARY = "write one whole, indexed file out of everything that can be read"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording, and the new file."""
    parser.add_argument(
        "log",
        type=Path,
        metavar="LOG",
        help="a recording; its later parts are joined to it; or a folder that holds one",
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT",
        help="the new file; it must not exist yet",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write it; what is in it is said on stdout, what is missing on stderr."""
    from nodal.errors import CommandError  # noqa: PLC0415
    from nodal.log.choosing import one_log  # noqa: PLC0415
    from nodal.log.deriving import recovered  # noqa: PLC0415
    from nodal.log.lines import derived_in_words  # noqa: PLC0415
    from recordings.parts import would_be_part  # noqa: PLC0415

    log = one_log(arguments.log)
    if would_be_part(arguments.output, log.path):
        raise CommandError(f"-o {arguments.output}: that name would make it a part of {log.path}")
    print(derived_in_words(recovered(log, arguments.output)))
    for damage in log.damage:
        print(f"nodal: warning: {damage}", file=sys.stderr)
    return 0
