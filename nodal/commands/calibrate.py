"""`nodal calibrate`: bring a bench up, step by step."""

import argparse

from nodal.arguments import add_subcommands
from nodal.calibrate import SUBCOMMANDS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand, with its own arguments."""
    add_subcommands(parser, "nodal.calibrate", SUBCOMMANDS)


def run(arguments: argparse.Namespace) -> int:
    """The exit status of the subcommand."""
    status: int = arguments.run_subcommand(arguments)
    return status
