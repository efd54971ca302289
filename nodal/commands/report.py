"""`nodal report`: one page on one recording, or on several side by side."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recordings, and where the page goes."""
    parser.add_argument(
        "logs", nargs="+", type=Path, metavar="LOG", help="a recording; its later parts belong to it"
    )
    parser.add_argument(
        "-o", dest="page", type=Path, metavar="PAGE.html", help="the page (default: beside the first LOG)"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """Write the page and print its path, or the figures."""
    import json  # noqa: PLC0415

    from nodal.report.page.writing import write_page  # noqa: PLC0415

    page, reports = write_page(arguments.logs, arguments.page)
    if arguments.json:
        print(json.dumps({"page": str(page), "runs": [report.as_builtins() for report in reports]}))
    else:
        print(page)
    return 0
