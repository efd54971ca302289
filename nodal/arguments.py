"""Arguments that several subcommands share. Imports nothing slow, so that help stays quick."""

import argparse
import importlib
from collections.abc import Sequence


def add_config_argument(parser: argparse.ArgumentParser) -> None:
    """`--config`, which nothing guesses: a bench is never simulated by accident."""
    parser.add_argument(
        "--config",
        required=True,
        metavar="BENCH",
        help="bench file (TOML), the folder of a bench.toml, or the name of one that comes with nodal: simulated",
    )


def add_process_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments that every process takes."""
    add_config_argument(parser)
    parser.add_argument(
        "--end-with", type=int, metavar="PID", help="end when the process that started this one, PID, ends"
    )


def add_timeout_argument(parser: argparse.ArgumentParser) -> None:
    """How long to wait for an answer."""
    parser.add_argument(
        "--timeout", type=float, default=5.0, metavar="S", help="seconds to wait for an answer (default 5)"
    )


def add_subcommands(parser: argparse.ArgumentParser, package: str, names: Sequence[str]) -> None:
    """One subcommand for each module of `package` in `names`: its SUMMARY, add_arguments and run."""
    subcommands = parser.add_subparsers(required=True, metavar="SUBCOMMAND")
    for name in names:
        module = importlib.import_module(f"{package}.{name}")
        summary: str = module.SUMMARY
        subcommand = subcommands.add_parser(
            name, help=summary, description=summary[0].upper() + summary[1:] + "."
        )
        module.add_arguments(subcommand)
        subcommand.set_defaults(run_subcommand=module.run)
