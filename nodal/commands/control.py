"""`nodal control`: from nodal points to tendon commands, at a steady rate."""

import argparse

from nodal.arguments import add_process_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Only what every process takes."""
    add_process_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Control until told to stop; however that ends, the tendons are let go."""
    from controller import process as controller  # noqa: PLC0415
    from drivers.dynamixel.actuators import TendonActuators  # noqa: PLC0415
    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415

    settings = read_bench(arguments.config).checked()
    with running(settings, "controller", arguments.end_with) as process:
        controller.run(
            settings.controller,
            settings.robot,
            TendonActuators(settings.servos),
            process.session,
            process.stop,
            process.healthy,
        )
    return 0
