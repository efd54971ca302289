"""The subcommands of `nodal`, one file each: `add_arguments(parser)` and `run(arguments) -> exit status`."""
