"""`nodal log`: what is in a recording, whether it is healthy, and other files made of it."""

import argparse

from nodal.arguments import add_subcommands

SUBCOMMANDS = ("info", "check", "recover", "cut", "export", "plot")
"""Each is a file of nodal/log with SUMMARY, add_arguments and run, as the files of nodal/commands are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand, with its own arguments."""
    add_subcommands(parser, "nodal.log", SUBCOMMANDS)


def run(arguments: argparse.Namespace) -> int:
    """The exit status of the subcommand."""
    status: int = arguments.run_subcommand(arguments)
    return status
