"""`nodal sense`: shape sensing, from the cameras' frames to nodal points."""

import argparse

from nodal.arguments import add_process_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Only what every process takes."""
    add_process_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Sense until told to stop."""
    from nodal.bench_file import load_bench  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415
    from sensing import process as sensing  # noqa: PLC0415

    bench = load_bench(arguments.config)
    settings = bench.settings
    with running(bench.settings, "sensing", arguments.end_with) as process:
        sensing.run(
            settings.sensing,
            settings.robot,
            bench.rig,
            bench.backgrounds,
            settings.cameras,
            process.session,
            process.stop,
            process.healthy,
        )
    return 0
