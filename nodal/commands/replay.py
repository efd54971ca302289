"""`nodal replay`: sensing and the controller over a log again, compared, imagined otherwise, or live onto the bus."""

import argparse
from pathlib import Path

from nodal.replay.live.arguments import add_live_arguments, refuse_mixture


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The logs, what to change, where to compute, how to answer."""
    parser.epilog = (
        "Exit status: 0 when every estimate, command and answer comes out as logged (or a what-if was written), "
        "1 when something differs or nothing could be compared, 2 for an error."
    )
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG", help="recording (MCAP), with its parts")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="changes",
        help="another setting of robot, sensing or controller, as in the bench file; writes a what-if (needs -o)",
    )
    parser.add_argument(
        "-o",
        "--out",
        type=Path,
        metavar="OUT",
        help="write the replay as a recording; with several logs, a folder for them",
    )
    parser.add_argument(
        "--law",
        type=Path,
        metavar="FILE",
        help="run this file as the recordings' own law: what a recording names or holds is never run by itself",
    )
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="processes to compute with (default: one for each core)"
    )
    parser.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="compute on a Dask cluster: its scheduler's address, or `local` (needs the extra `cluster`)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    add_live_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Replay; see the epilog for the exit status."""
    refuse_mixture(arguments)
    if arguments.live:
        from nodal.replay.live.playing import replay_live  # noqa: PLC0415

        return replay_live(arguments)
    from nodal.replay.request import Request, replay  # noqa: PLC0415

    request = Request(
        logs=arguments.logs,
        changes=arguments.changes,
        out=arguments.out,
        law=arguments.law,
        jobs=arguments.jobs,
        cluster=arguments.dask,
        as_json=arguments.json,
    )
    return replay(request)
