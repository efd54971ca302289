"""`nodal rendezvous`: the router-mode session through which a bench's processes find one another."""

import argparse

from nodal.arguments import add_process_arguments

PULSE_S = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Only what every process takes."""
    add_process_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until told to stop; raises EndpointError when the endpoint is in use."""
    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.running import running  # noqa: PLC0415

    with running(read_bench(arguments.config).settings, "rendezvous", arguments.end_with) as process:
        process.healthy()
        while not process.stop.wait(PULSE_S):
            process.healthy()
    return 0
