"""`nodal log info`: what is inside a recording."""

import argparse
from pathlib import Path

SUMMARY = "what is inside: parts, topics with their rates, ages and drops, states, targets, versions"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording."""
    parser.add_argument("log", type=Path, metavar="LOG", help="a recording; its later parts belong to it")


def run(arguments: argparse.Namespace) -> int:
    """Print the page."""
    from collections import Counter  # noqa: PLC0415

    from recordings import Log  # noqa: PLC0415

    log = Log(arguments.log)
    for topic, count in sorted(Counter(one.topic for one in log.messages()).items()):
        print(f"{topic:28} {count:8}")
    return 0
