"""`nodal log info`: what is inside a recording."""

import argparse
from pathlib import Path

SUMMARY = (
    "what is inside: files, topics with rates and losses, ages, states, targets, what was asked, versions"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording."""
    parser.add_argument(
        "log",
        type=Path,
        metavar="LOG",
        help="a recording; its later parts belong to it; or a folder that holds one",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(arguments: argparse.Namespace) -> int:
    """Print the page."""
    import msgspec  # noqa: PLC0415

    from nodal.log.choosing import one_log  # noqa: PLC0415
    from nodal.log.page import as_builtins, as_text  # noqa: PLC0415
    from nodal.log.survey import survey  # noqa: PLC0415

    found = survey(one_log(arguments.log))
    if arguments.json:
        print(msgspec.json.format(msgspec.json.encode(as_builtins(found)), indent=1).decode())
    else:
        print(as_text(found))
    return 0
