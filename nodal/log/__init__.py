"""`nodal log`: one file a subcommand, and what they share."""
