"""`nodal log`: what is in a recording, whether it is healthy, and other files made of it."""

import argparse
import importlib

SUBCOMMANDS = ("info", "check", "recover", "cut", "export", "plot")
"""Each is a file of nodal/log with SUMMARY, add_arguments and run, as the files of nodal/commands are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand, with its own arguments."""
    subcommands = parser.add_subparsers(required=True, metavar="SUBCOMMAND")
    for name in SUBCOMMANDS:
        module = importlib.import_module(f"nodal.log.{name}")
        summary: str = module.SUMMARY
        subcommand = subcommands.add_parser(
            name, help=summary, description=summary[0].upper() + summary[1:] + "."
        )
        module.add_arguments(subcommand)
        subcommand.set_defaults(run_subcommand=module.run)


def run(arguments: argparse.Namespace) -> int:
    """The exit status of the subcommand."""
    status: int = arguments.run_subcommand(arguments)
    return status
