"""The cameras before sensing runs: what is plugged in, what it can do, and how good its pictures are."""

SUBCOMMANDS = ("list", "write", "look")
"""Each is a file of nodal/cameras with SUMMARY, add_arguments and run, as the files of nodal/commands are."""
