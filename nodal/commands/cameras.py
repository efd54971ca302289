"""`nodal cameras`: find, choose and judge cameras."""

import argparse

from nodal.arguments import add_subcommands
from nodal.cameras import SUBCOMMANDS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand, with its own arguments."""
    add_subcommands(parser, "nodal.cameras", SUBCOMMANDS)


def run(arguments: argparse.Namespace) -> int:
    """The exit status of the subcommand."""
    status: int = arguments.run_subcommand(arguments)
    return status
