"""`nodal record`: the recorder, and what it may be asked while it runs."""

import argparse
from pathlib import Path

from nodal.arguments import add_process_arguments, add_timeout_argument

ACTIONS = {
    "start": "begin a recording",
    "stop": "finish it",
    "save": "save the last seconds that were kept in memory, and those that follow (recorder.rolling_s)",
    "status": "say what is being recorded and where, how long and large it is, what was lost, and how much room is left",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The action and the file, beside what every process takes."""
    meanings = "; ".join(f"{name}: {meaning}" for name, meaning in ACTIONS.items())
    parser.add_argument(
        "action",
        nargs="?",
        choices=ACTIONS,
        help=f"ask a recorder that runs ({meanings}); without it, run the recorder",
    )
    add_process_arguments(parser)
    parser.add_argument(
        "--file",
        type=Path,
        metavar="MCAP",
        help="the recording (default: named by the time, in the bench file's recorder.folder); "
        "for `start` and `save` a path on the recorder's host, which begins in that folder unless it is absolute",
    )
    add_timeout_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Ask: 0 when it is accepted, 3 when it is refused. Or record until told to stop."""
    return _record(arguments) if arguments.action is None else _ask(arguments)


def _record(arguments: argparse.Namespace) -> int:
    from nodal.bench_file import load_bench, make_folder  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415
    from recordings import process as recordings  # noqa: PLC0415

    bench = load_bench(arguments.config)
    make_folder(Path(bench.settings.recorder.folder), "recorder.folder")
    with running(bench.settings, "recorder", arguments.end_with) as process:
        recordings.run(
            bench.settings.recorder,
            arguments.file,
            bench.attachments(),
            process.session,
            process.stop,
            process.healthy,
        )
    return 0


def _ask(arguments: argparse.Namespace) -> int:
    from messaging.recorder import RecorderAction, RecorderRequest  # noqa: PLC0415
    from messaging.topics import RECORDER_DO  # noqa: PLC0415
    from nodal.asking import ask  # noqa: PLC0415

    request = RecorderRequest(action=RecorderAction(arguments.action), file=str(arguments.file or ""))
    return ask(arguments.config, RECORDER_DO, request, arguments.timeout)
