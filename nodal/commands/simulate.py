"""`nodal simulate`: the bench that stands in - rendered cameras, servos behind a pty, and the robot."""

import argparse

from nodal.arguments import add_process_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Only what every process takes."""
    add_process_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Simulate until told to stop; raises BenchFileError for a bench that is not simulated."""
    from pathlib import Path  # noqa: PLC0415

    from drivers.simulated import process as simulation  # noqa: PLC0415
    from nodal.bench_checks import check  # noqa: PLC0415
    from nodal.bench_file import make_folder, read_bench  # noqa: PLC0415
    from nodal.calibration_file import load_rig  # noqa: PLC0415
    from nodal.errors import BenchFileError  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415

    bench = read_bench(arguments.config)
    settings = bench.settings
    if settings.simulation is None:
        raise BenchFileError(f"{bench.path}: it has no [simulation], so there is nothing to simulate")
    rig = {
        camera.camera: camera for camera in load_rig(Path(settings.simulation.rig or settings.calibration))
    }
    check(bench.path, settings, rig)
    make_folder(Path(settings.simulation.servos.link).parent, "simulation.servos.link")
    with running(settings, "simulation", arguments.end_with) as process:
        simulation.run(
            settings.simulation,
            tuple(rig[name] for name in settings.cameras),
            settings.zenoh,
            settings.name,
            settings.board,
            process.session,
            process.stop,
            process.healthy,
        )
    return 0
