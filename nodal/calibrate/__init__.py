"""Calibration, step by step: the board, the cameras, the robot frame, the background, the robot."""

SUBCOMMANDS: tuple[str, ...] = ("board", "cameras", "base", "background", "robot")
"""Each is a file of nodal/calibrate with SUMMARY, add_arguments and run, as the files of nodal/commands are."""
