"""What was calibrated: shown, checked against a recording, converted from and to other tools' files."""

SUBCOMMANDS: tuple[str, ...] = ("show", "check", "convert", "report")
"""Each is a file of nodal/calibration with SUMMARY, add_arguments and run, as the files of nodal/commands are."""
