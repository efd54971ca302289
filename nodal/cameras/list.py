"""`nodal cameras list`: what is plugged in, and what it can do."""

import argparse

from nodal.exit_status import REFUSED

SUMMARY = "which cameras are plugged in: lasting path, picture sizes and rates, controls and their ranges"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Words or JSON."""
    parser.add_argument("--json", action="store_true", help="print everything as JSON")


def run(arguments: argparse.Namespace) -> int:
    """0, or 3 when there is no camera."""
    import msgspec  # noqa: PLC0415

    from drivers.cameras.v4l2.listing import devices  # noqa: PLC0415
    from nodal.cameras.device_words import described  # noqa: PLC0415
    from nodal.cameras.devices import NO_CAMERA  # noqa: PLC0415

    found = devices()
    if arguments.json:
        print(msgspec.json.format(msgspec.json.encode(found, enc_hook=str), indent=2).decode())
    else:
        print("\n".join(map(described, found)) if found else NO_CAMERA)
    return 0 if found else REFUSED
