"""Arguments that several subcommands share. Imports nothing slow, so that help stays quick."""

import argparse


def add_config_argument(parser: argparse.ArgumentParser) -> None:
    """`--config`, which nothing guesses: a bench is never simulated by accident."""
    parser.add_argument(
        "--config",
        required=True,
        metavar="BENCH",
        help="bench file (TOML), or the name of one that comes with nodal: simulated",
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
