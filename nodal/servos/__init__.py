"""`nodal servos`: what is on the servo bus, and whether it is what the bench file says.

Each subcommand is a file with SUMMARY, add_arguments and run: `list`, `identify`, `reboot`, `setup`, `check`. Behind them:
`scan` (who answers), `setting_up` (what is written), `findings` (what differs, in words), `words` (values and tables).
"""
