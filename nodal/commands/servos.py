"""`nodal servos`: the servo bus without the controller - who is on it, which is which, set up, check."""

import argparse

from nodal.arguments import add_subcommands

SUBCOMMANDS = ("list", "identify", "reboot", "setup", "check")
"""Each is a file of nodal/servos with SUMMARY, add_arguments and run, as the files of nodal/commands are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand, with its own arguments."""
    add_subcommands(parser, "nodal.servos", SUBCOMMANDS)


def run(arguments: argparse.Namespace) -> int:
    """The exit status of the subcommand."""
    status: int = arguments.run_subcommand(arguments)
    return status
