"""`nodal log check`: whether recordings can be relied on, one finding a line."""

import argparse
import sys
from pathlib import Path

SUMMARY = "whether recordings are healthy: damage, losses, rates, silences, attachments, flags"
EPILOG = "Exit status: 0 when every recording is healthy, 1 when anything is to be said against one, 2 for an error."

UNHEALTHY, ERROR = 1, 2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recordings."""
    parser.epilog = EPILOG
    parser.add_argument(
        "logs",
        type=Path,
        nargs="+",
        metavar="LOG",
        help="a recording with its later parts, or a folder of recordings",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(arguments: argparse.Namespace) -> int:
    """Look through all; see the epilog for the exit status."""
    import msgspec  # noqa: PLC0415

    from messaging.errors import NodalError  # noqa: PLC0415
    from nodal.log.choosing import logs_in  # noqa: PLC0415
    from nodal.log.health import Finding, findings  # noqa: PLC0415
    from nodal.log.lines import aligned, counted  # noqa: PLC0415
    from nodal.log.survey import survey  # noqa: PLC0415

    found: dict[str, list[Finding]] = {}
    failed = False
    for path in arguments.logs:
        try:
            found |= {str(log.path): findings(survey(log)) for log in logs_in(path)}
        except NodalError as error:
            # one that cannot be read at all keeps nobody from a verdict on the others
            print(f"nodal: error: {error}", file=sys.stderr)
            failed = True
    if arguments.json:
        plain = {
            path: [{"kind": one.kind, "text": one.text} for one in wrong] for path, wrong in found.items()
        }
        print(msgspec.json.format(msgspec.json.encode(plain), indent=1).decode())
    else:
        for path, wrong in found.items():
            print(f"{path}: {counted(len(wrong), 'finding') if wrong else 'healthy'}")
            for line in aligned((one.kind, one.text) for one in wrong):
                print(f"  {line}")
    if failed:
        return ERROR
    return UNHEALTHY if any(found.values()) else 0
