"""`nodal record`: everything that the table of topics wants logged, into an MCAP file."""

import argparse
from pathlib import Path

from nodal.arguments import add_process_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The file, beside what every process takes."""
    add_process_arguments(parser)
    parser.add_argument(
        "--file",
        type=Path,
        metavar="MCAP",
        help="the recording (default: named by the time, in the bench file's recorder.folder)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Record until told to stop; a recording that was cut off goes on in its next part."""
    import time  # noqa: PLC0415

    from nodal.bench_file import load_bench, make_folder  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415
    from recordings import process as recordings  # noqa: PLC0415
    from recordings.parts import new_path  # noqa: PLC0415

    bench = load_bench(arguments.config)
    folder = make_folder(Path(bench.settings.recorder.folder), "recorder.folder")
    file = arguments.file or new_path(folder, time.time_ns())
    with running(bench, "recorder", arguments.end_with) as process:
        recordings.run(
            bench.settings.recorder, file, bench.attachments(), process.session, process.stop, process.healthy
        )
    return 0
